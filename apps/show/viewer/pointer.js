// What is under the pointer.
'use strict';

function showTip(x, y, text) {
  tip.textContent = text;
  tip.style.display = 'block';
  tip.style.left = Math.min(x + 14, window.innerWidth - tip.offsetWidth - 8) + 'px';
  tip.style.top = Math.max(4, Math.min(y + 12, window.innerHeight - tip.offsetHeight - 8)) + 'px';
}

function hideTip() {
  tip.style.display = 'none';
}

// The point of a layer that is nearest to the pointer on the screen, within 8 pixels: {index, depth}.
function nearestPoint(name, positions, count, x, y) {
  if (!layers[name] || !layers[name].visible) return null;
  let best = null, least = 64;
  const p = new THREE.Vector3();
  for (let i = 0; i < count; ++i) {
    p.set(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]).project(camera);
    const dx = 0.5 * (p.x + 1) * window.innerWidth - x, dy = 0.5 * (1 - p.y) * window.innerHeight - y;
    const square = dx * dx + dy * dy;
    if (p.z > 1 || square > least || (square === least && best && p.z > best.depth)) continue;
    least = square;
    best = {index: i, depth: p.z};
  }
  return best;
}

function stateText(k) {
  const s = scene.states, i = stateOrder[k];
  return 'state at ' + inMillimetres(triple(s.at, i)) + '\n' + inNewton(triple(s.force, i)) + '\n' +
         labelNames[s.label[i]] + ', ' + s.outcomes[s.outcome[i]] +
         (Number.isFinite(s.known[i]) ? ', known at ' + digits(s.known[i], 4) + ' s' : '');
}

function pathText(i) {
  const run = scene.run;
  return 'hand at ' + run.t[i].toFixed(3) + ' s: ' + inMillimetres(triple(run.at, i)) + '\n' +
         inNewton(triple(run.sent, i)) + '\n' + momentText(i);
}

// ", tumour": the region of a triangle of the surface.
function regionText(triangle) {
  const number = scene.body.region[triangle];
  return number ? ', ' + scene.body.regions[number - 1].name : '';
}

function surfaceText(hit) {
  if (hit.object.userData.region !== undefined)
    return scene.body.regions[hit.object.userData.region].name + ', surface inside at ' +
           inMillimetres(hit.point.toArray());
  if (hit.object.geometry !== bodyGeometry) {
    const place = hit.point.toArray();
    return labelNames[labelAt(place)] + ' at ' + inMillimetres(place);
  }
  const body = scene.body, at = bodyGeometry.attributes.position.array;
  const vertex = [hit.face.a, hit.face.b, hit.face.c].sort(
      (a, b) => hit.point.distanceTo(new THREE.Vector3(...triple(at, a))) -
                hit.point.distanceTo(new THREE.Vector3(...triple(at, b))))[0];
  const corner = drawn.node[vertex];
  const rest = triple(body.nodes, corner), moved = triple(at, vertex).map((v, i) => v - rest[i]);
  const groups = body.groups.filter(g => g.nodes.includes(corner)).map(g => g.name);
  return 'node ' + body.node[corner] + ['', ', clamp', ', contact'][body.role[corner]] + regionText(hit.faceIndex) +
         (groups.length ? '\ngroups: ' + groups.join(', ') : '') +
         '\nin the mesh ' + inMillimetres(rest.map((v, i) => v + body.rest[i])) +
         (norm(body.rest) > 0 ? '\nfrom the contact ' + inMillimetres(rest) : '') +
         (norm(moved) > 0 ? '\nmoved by ' + digits(norm(moved), 3) + ' mm' : '');
}

// Text for what is under a pixel; null where nothing is.
function readOff(x, y) {
  const found = [];
  if (layers.states) {
    const shown = layers.states.geometry;
    const hit = nearestPoint('states', shown.attributes.position.array,
                             Math.min(shown.drawRange.count, stateOrder.length), x, y);
    if (hit) found.push({depth: hit.depth, text: stateText(hit.index)});
  }
  if (scene.run) {
    const hit = nearestPoint('path', scene.run.at, scene.run.t.length, x, y);
    if (hit) found.push({depth: hit.depth - 1e-5, text: pathText(hit.index)});
  }
  if (!found.length) {
    const ray = new THREE.Raycaster();
    ray.setFromCamera({x: 2 * x / window.innerWidth - 1, y: 1 - 2 * y / window.innerHeight}, camera);
    const solid = planes.map(p => p.mesh).filter(m => m.visible);
    if (layers.body && layers.body.visible && bodyMaterials[1].opacity > 0.05)
      solid.push(layers.body.children[1]);
    // A body that hides what is inside it is hit first.
    if (scene.body && !(layers.body.visible && bodyMaterials[1].opacity > 0.7))
      solid.unshift(...regionLayers().filter(n => layers[n] && layers[n].visible).map(n => layers[n]));
    const cuts = scene.body ? bodyMaterials[1].clippingPlanes || [] : [];
    const ofBody = hit => hit.object.geometry === bodyGeometry;
    const hits = ray.intersectObjects(solid).filter(
        hit => !ofBody(hit) || cuts.every(cut => cut.distanceToPoint(hit.point) >= 0));
    const plane = hits.find(hit => !ofBody(hit) && hit.object.userData.region === undefined);
    const thin = scene.body && bodyMaterials[1].opacity < 0.5;  // the plane shows through
    const inner = hits.find(hit => hit.object.userData.region !== undefined);
    const hit = plane && thin ? plane : inner && thin ? inner : hits[0];
    if (hit) return surfaceText(hit);
  }
  found.sort((a, b) => a.depth - b.depth);
  return found.length ? found[0].text : null;
}

let pointer = null;
renderer.domElement.addEventListener('pointermove', event => {
  if (event.buttons) return hideTip();
  if (!pointer) requestAnimationFrame(() => {
    const {x, y} = pointer;
    pointer = null;
    const text = readOff(x, y);
    if (text) showTip(x, y, text); else hideTip();
  });
  pointer = {x: event.clientX, y: event.clientY};
});
renderer.domElement.addEventListener('pointerleave', hideTip);
