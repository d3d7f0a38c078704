// Puts the page together. The view can be given in the address:
// #az=30&el=20&zoom=2&t=1.5&x=0&y=5&z=0&show=edges&hide=body&opacity=0.5&cut&tip=400,300
'use strict';

function takeAddress() {
  const view = new URLSearchParams(window.location.hash.slice(1));
  const number = (name, otherwise) => view.has(name) ? Number(view.get(name)) : otherwise;
  for (const [word, on] of [['show', true], ['hide', false]])
    for (const name of (view.get(word) || '').split(',').filter(n => layers[n])) {
      layers[name].visible = on;
      byId('layer-' + name).checked = on;
    }
  planes.forEach((plane, axis) => {
    if (view.has('xyz'[axis])) plane.move(number('xyz'[axis]));
  });
  if (view.has('opacity') && scene.body) setOpacity(Number(byId('opacity').value = number('opacity')));
  if (view.has('t') && scene.run) setTime(number('t'));
  if (view.has('az') || view.has('el') || view.has('zoom'))
    look(number('az', start[0]), number('el', start[1]), 1 / number('zoom', 1));
  if (view.has('cut') && layers.body) byId('cut-body').click();
  if (view.has('tip')) {
    const [x, y] = view.get('tip').split(',').map(Number);
    camera.updateMatrixWorld();
    const text = readOff(x, y);
    if (text) showTip(x, y, text);
  }
  draw();
}

if (scene.body) makeBody();
if (scene.box) makeBox();
makeAxes();
if (scene.states) makeStates();
if (scene.labels) makePlanes();
if (scene.run) makeRun();
resize();
makePanel();
// The camera stands on the side of the contact.
const start = scene.view;
look(start[0], start[1], 1);
if (scene.run) makeTime();
takeAddress();
controls.addEventListener('change', () => {
  cutBody();
  draw();
});
window.addEventListener('resize', resize);
window.addEventListener('hashchange', takeAddress);
window.forefeel = {scene, layers, look, readOff, setTime, movePlane};
