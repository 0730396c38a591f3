// The page of a report: text, tables, charts and films, in their order. No text is parsed as HTML.
function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

// Text with `code`; a backtick without a partner stays.
function marked(text) {
  return text.split(/`([^`]*)`/).map((part, i) => i % 2 ? element("code", {}, part) : part);
}

function makeTable(columns, rows, caption = "") {
  const number = text => /^[+\-.<>=~ ]*[0-9]/.test(text);
  const styles = columns.map((_, c) => {
    const filled = rows.map(row => row[c]).filter(text => text !== "");
    if (filled.length && filled.every(text => number(text) && text.length <= 24)) return "number";
    return filled.every(text => text.length <= 24) ? "brief" : "";
  });
  // Rows whose first cells are empty continue the group above.
  const blanks = row => { const at = row.findIndex(text => text !== ""); return at < 0 ? row.length : at; };
  const indent = Math.max(0, ...rows.map(blanks));
  const line = (row, tag) => element("tr", tag === "td" && blanks(row) < indent ? {class: "group"} : {},
    ...row.map((text, c) => element(tag, styles[c] ? {class: styles[c]} : {}, ...marked(text))));
  const table = element("table", {}, element("thead", {}, line(columns, "th")),
                        element("tbody", {}, ...rows.map(row => line(row, "td"))));
  const scroll = element("div", {class: "scroll", tabindex: 0}, table);
  return caption ? element("div", {}, element("p", {class: "caption"}, ...marked(caption)), scroll) : scroll;
}

// Black or white, whichever can be read on the colour "#rrggbb".
function textOn(colour) {
  const [red, green, blue] = [1, 3, 5].map(at => parseInt(colour.slice(at, at + 2), 16));
  return 0.299 * red + 0.587 * green + 0.114 * blue < 140 ? "#fff" : "#111";
}

function cellTable(chart) {
  const rows = chart.rows.map((name, r) => element("tr", {}, element("th", {}, `${chart.y_label} ${name}`),
    ...chart.values[r].map((value, c) => value < 0 ? element("td") :
      element("td", {style: `background:${chart.classes[value].colour};color:${textOn(chart.classes[value].colour)}`,
                     title: chart.classes[value].label}, (chart.marks[r] || [])[c] || ""))));
  return element("table", {}, element("caption", {}, chart.title), ...rows,
    element("tr", {}, element("th"), ...chart.columns.map(name => element("th", {}, name))),
    element("tr", {}, element("th"), element("th", {colspan: chart.columns.length}, chart.x_label)));
}

function drawCells({charts, caption}) {
  const legend = (charts[0]?.classes ?? []).map(({label, colour}) =>
    element("span", {style: "display:flex;align-items:center;gap:.4rem"},
            element("span", {class: "swatch", style: `background:${colour}`}), label));
  const drawing = element("div", {class: "drawing"}, element("div", {class: "maps"}, ...charts.map(cellTable)),
                          element("div", {class: "legend"}, ...legend));
  main.append(element("figure", {}, drawing, element("figcaption", {}, ...marked(caption))));
}

function drawCriteria(criteria) {
  const table = makeTable(["criterion", "bound", "measured", ""],
                          criteria.map(c => [c.what, c.bound, c.measured, c.verdict]));
  const rows = table.querySelectorAll("tbody tr");
  rows.forEach((row, i) => { row.lastChild.className = criteria[i].verdict.toLowerCase(); });
  main.append(table);
}

const show = {
  heading: text => main.append(element("h3", {}, text)),
  paragraph: text => main.append(element("p", {}, ...marked(text))),
  table: ({columns, rows, caption}) => main.append(makeTable(columns, rows, caption)),
  criteria: drawCriteria, cells: drawCells, charts: data => main.append(chartFigure(data)),
  film: data => main.append(showFilm(data))};

const report = JSON.parse(document.getElementById("report").textContent);
const main = document.querySelector("main");
document.title = document.querySelector("h1").textContent = report.title;
document.getElementById("subtitle").append(...marked(report.subtitle));
if (report.sections.length > 3)
  document.querySelector("nav").append(element("ol", {}, ...report.sections.map((section, i) =>
    element("li", {}, element("a", {href: `#section-${i + 1}`}, section.title)))));
report.sections.forEach((section, i) => {
  if (section.title) main.append(element("h2", {id: `section-${i + 1}`}, section.title));
  for (const part of section.parts) show[part.kind](part[part.kind]);
});
