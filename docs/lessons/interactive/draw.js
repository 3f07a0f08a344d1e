// Curves in an SVG, with axes, for the interactive pages. Colours are those of Okabe & Ito, which colour-blind readers tell apart, dark enough for text.
const COLOURS = ["#0072b2", "#b85000", "#007a59", "#a8557f"]

function element(name, attributes, text) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name)
  for (const key in attributes) made.setAttribute(key, attributes[key])
  if (text !== undefined) made.textContent = text
  return made
}

// Draws curves, lists of [x, y], with names at their ends. axes: {x: [least, largest], y: [...], names: [of x, of y], marks: [x, ...]}
function plot(svg, axes, curves) {
  const [left, right, top, bottom] = [70, 700, 15, 340]
  const at = ([x, y]) => [left + (right - left) * (x - axes.x[0]) / (axes.x[1] - axes.x[0]),
    bottom - (bottom - top) * (Math.min(Math.max(y, axes.y[0]), axes.y[1]) - axes.y[0]) / (axes.y[1] - axes.y[0])]
  svg.setAttribute("viewBox", "0 0 900 400")
  svg.replaceChildren(element("rect", { x: left, y: top, width: right - left, height: bottom - top, fill: "none", stroke: "#888" }))
  for (let n = 0; n <= 4; n++) {
    const [x, y] = [0, 1].map((side) => [axes.x, axes.y][side].reduce((from, to) => from + (to - from) * n / 4))
    svg.append(element("text", { x: at([x, 0])[0], y: bottom + 20, "text-anchor": "middle" }, +x.toFixed(2)))
    svg.append(element("text", { x: left - 8, y: at([0, y])[1] + 5, "text-anchor": "end" }, +y.toFixed(2)))
  }
  svg.append(element("text", { x: (left + right) / 2, y: bottom + 45, "text-anchor": "middle" }, axes.names[0]))
  svg.append(element("text", { transform: `translate(18 ${(top + bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, axes.names[1]))
  for (const x of axes.marks ?? []) svg.append(element("path", { d: `M${at([x, 0])[0]} ${top}V${bottom}`, stroke: "#888", "stroke-dasharray": "4 4" }))
  curves.forEach(({ name, points, dashed }, n) => {
    svg.append(element("polyline", { points: points.map(at).join(" "), fill: "none", stroke: COLOURS[n], "stroke-width": 2.5, "stroke-dasharray": dashed ? "7 5" : "none" }))
    svg.append(element("text", { x: right + 8, y: top + 20 + 24 * n, style: `fill: ${COLOURS[n]}` }, name))
  })
}

// Calls show() now and whenever an input of the page changes.
function live(show) {
  for (const input of document.querySelectorAll("input, select")) input.addEventListener("input", show)
  show()
}

const value = (name) => { const input = document.getElementById(name); return input.type === "range" ? +input.value : input.value }
const say = (name, text) => { document.getElementById(name).textContent = text }
const curve = (f, from, to) => Array.from({ length: 241 }, (_, n) => { const x = from + (to - from) * n / 240; return [x, f(x)] })
