#include "apps/picture/page.hpp"

#include <fmt/format.h>

#include "geometry/common/utf8.hpp"

namespace forefeel {
namespace {

constexpr const char* style = R"(
body{margin:0;background:#faf8f4;color:#1b1b1b;
font:15px/1.5 system-ui,-apple-system,"Segoe UI",Helvetica,Arial,sans-serif}
main{max-width:1000px;margin:0 auto;padding:28px 24px 60px}
h1{font-size:26px;margin:0 0 2px}h2{font-size:18px;margin:34px 0 8px}
.muted,.sub,figcaption{color:#5a5a5a}.sub{margin:0 0 18px}
.tiles{display:grid;grid-template-columns:repeat(4,1fr);gap:10px}
.tile{background:#fff;border:1px solid #e4e1da;border-radius:8px;padding:10px 12px}
.tile b{display:block;font-size:22px;font-variant-numeric:tabular-nums}
.tile span{font-size:12.5px;color:#5a5a5a;line-height:1.35;display:block}
figure{margin:0;background:#fff;border:1px solid #e4e1da;border-radius:8px;padding:10px}
figure svg{width:100%;height:auto;display:block}
figcaption{font-size:13px;padding:4px 6px 2px}
.legend span{margin-right:18px}
.legend i{display:inline-block;width:13px;height:13px;border:1px solid #8a8a8a;border-radius:3px;
margin-right:6px;vertical-align:-2px}
.verdict{background:#fff;border:1px solid #e4e1da;border-left:6px solid #e69f00;border-radius:8px;
padding:2px 18px;margin:0 0 14px}
.verdict.good{border-left-color:#2a9d8f}.tile.good{border-left:5px solid #2a9d8f}
.tile.warn{border-left:5px solid #e69f00;background:#fff8e8}
.tile.bad{border-left:5px solid #c02020;background:#fdeeee}.tile.bad b{color:#a01818}
.legend i.line{height:0;border:0;border-top:2px solid var(--ink);width:20px;border-radius:0;
vertical-align:4px}
.legend i.dash{height:0;border:0;border-top:2px dashed var(--ink);width:20px;border-radius:0;
vertical-align:4px}
.legend i.dot{width:7px;height:7px;border:0;border-radius:50%;background:var(--ink);vertical-align:2px}
.legend i.box{background:var(--ink)}.legend span{display:inline-block}
p.legend{margin:2px 0 6px;font-size:13.5px}
canvas{display:block;width:100%;touch-action:none}
.bar{margin:0 0 8px;display:flex;flex-wrap:wrap;gap:6px;align-items:center}
.bar input{flex:1;min-width:120px}
button{font:inherit;white-space:nowrap;font-size:13px;padding:2px 10px;
border:1px solid #b9b4a8;border-radius:6px;background:#f7f5f0;cursor:pointer}
.read{display:flex;flex-wrap:wrap;gap:2px 18px;min-height:44px;margin:8px 4px;
font-variant-numeric:tabular-nums;font-size:13.5px}
.read em{color:#5a5a5a;font-style:normal}.maps{display:grid;grid-template-columns:repeat(3,1fr);gap:8px}
.maps canvas{height:280px}
.maps figcaption{grid-column:1/-1}.scroll{overflow-x:auto}.moments td{vertical-align:top}
.moments td:last-child{min-width:230px}
.moments td.n,.ranking td.n{white-space:nowrap}
.ranking td,.ranking th{padding:2px 6px}.scroll td:not(.n){overflow-wrap:anywhere}
.ranking td.name,.ranking th.name{min-width:90px}figure{margin-bottom:12px}
.note{background:#fff7e0;border:1px solid #ecd9a0;border-radius:8px;padding:8px 14px}
ul.note{padding-left:32px}
table{border-collapse:collapse;background:#fff;font-size:13px;margin:0 0 12px;break-inside:avoid;width:100%}
td,th{border:1px solid #e4e1da;padding:2px 8px;text-align:left}th{background:#f2efe8}
td.n{text-align:right;font-variant-numeric:tabular-nums}
.columns td:first-child{overflow-wrap:break-word}.columns td.n{overflow-wrap:anywhere;min-width:62px}h1,h2,h3,p,li,code{overflow-wrap:anywhere}
.columns{columns:3;column-gap:14px}.wide td.n{text-align:left;word-break:break-word}
summary{cursor:pointer;font-size:18px;font-weight:600;margin:30px 0 8px}
@media(max-width:940px){.moments td.n,.ranking td.n{white-space:normal}.moments td:last-child{min-width:150px}
.scroll td,.scroll th{padding:2px 4px}}
@media print{.scroll{overflow:visible}.moments td.n,.ranking td.n{white-space:normal}}
@media(max-width:760px){.tiles{grid-template-columns:repeat(2,1fr)}.columns{columns:1}
.maps{grid-template-columns:1fr}}
)";

}  // namespace

std::string html_escaped(std::string_view text) {
  std::string safe;
  for (const char c : valid_utf8(text)) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

std::string html_page(const std::string& title, const std::string& body) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width\">\n"
      "<title>{}</title>\n<style>{}</style></head><body><main>\n{}</main></body></html>\n",
      html_escaped(title), style, body);
}

}  // namespace forefeel
