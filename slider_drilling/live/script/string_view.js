// The string along its well, coloured by zone, and beside it the rotation at each depth.
import { begin, legend, line, text, ticks } from "./paint.js";

export function drawString(canvas, path, rotation, labels) {
  const sheet = begin(canvas);
  if (!sheet) return;
  const { pen, width, height, colours: c } = sheet;
  if (!path) {
    text(pen, "no rig file yet", width / 2, height / 2, { size: 13, colour: c.faint, align: "center" });
    return;
  }
  const stacked = width < 420;
  const section = stacked ? [0, 0, width, 0.5 * height - 12] : [0, 0, 0.54 * width, height - 24];
  const twist = stacked ? [0, 0.5 * height - 6, width, 0.5 * height - 18] : [0.54 * width, 0, 0.46 * width, height - 24];
  drawSection(pen, c, path, rotation, section, labels);
  drawTwist(pen, c, path, rotation, twist, labels);
  zones(pen, c, path, rotation, width, height, labels);
}

function zone(depth, rotation, c) {
  if (rotation.rocked_to === null || rotation.rocked_to === undefined) return c.still;
  if (depth <= rotation.rocked_to) return c.rocked;
  return depth >= rotation.reactive_from ? c.reactive : c.still;
}

function drawSection(pen, c, path, rotation, [left, top, wide, tall], labels) {
  const reach = Math.max(...path.departure, 1), deep = Math.max(...path.verticalDepth, 1);
  const scale = Math.min((wide - 74) / reach, (tall - 46) / deep);
  const x = (departure) => left + 48 + departure * scale, y = (depth) => top + 24 + depth * scale;
  text(pen, `vertical section, ${labels.length}`, left + 6, top + 10, { colour: c.faint });
  for (const tick of ticks(0, deep, 4)) {
    line(pen, [[x(0), y(tick)], [x(reach), y(tick)]], c.grid, 0.7);
    text(pen, String(tick), x(0) - 6, y(tick), { size: 10, colour: c.faint, align: "right" });
  }
  for (const tick of ticks(0, reach, 3).slice(1)) {
    text(pen, String(tick), x(tick), y(deep) + 12, { size: 10, colour: c.faint, align: "center" });
  }
  for (let k = 1; k < path.depth.length; k++) {
    const middle = 0.5 * (path.depth[k - 1] + path.depth[k]);
    line(pen, [[x(path.departure[k - 1]), y(path.verticalDepth[k - 1])], [x(path.departure[k]), y(path.verticalDepth[k])]],
      zone(middle, rotation, c), 5);
  }
  const end = path.depth.length - 1;
  pen.fillStyle = c.text;
  pen.beginPath();
  pen.arc(x(path.departure[end]), y(path.verticalDepth[end]), 4.5, 0, 2 * Math.PI);
  pen.fill();
}

function drawTwist(pen, c, path, rotation, [left, top, wide, tall], labels) {
  text(pen, `turn about the centre, ${labels.turn}`, left + 10, top + 10, { colour: c.faint });
  if (!rotation.amplitude) return;
  const low = Math.min(...rotation.amplitude.map((amplitude, k) => -rotation.lag[k] - amplitude));
  const high = Math.max(...rotation.amplitude.map((amplitude, k) => amplitude - rotation.lag[k]), 0);
  const most = path.depth[path.depth.length - 1], span = Math.max(high - low, 0.5);
  const x = (turn) => left + 24 + (turn - low) / span * (wide - 40);
  const y = (depth) => top + 24 + depth / most * (tall - 46);
  for (const tick of ticks(low, low + span, 4)) {
    line(pen, [[x(tick), y(0)], [x(tick), y(most)]], c.grid, tick === 0 ? 1.4 : 0.7);
    text(pen, String(+tick.toFixed(3)), x(tick), y(most) + 11, { size: 10, colour: c.faint, align: "center" });
  }
  pen.globalAlpha = 0.22;
  for (let k = 1; k < path.depth.length; k++) {
    if (!rotation.amplitude[k - 1]) continue;
    const [a, b] = [k - 1, k];
    pen.fillStyle = zone(0.5 * (path.depth[a] + path.depth[b]), rotation, c);
    pen.beginPath();
    pen.moveTo(x(-rotation.lag[a] - rotation.amplitude[a]), y(path.depth[a]));
    pen.lineTo(x(-rotation.lag[a] + rotation.amplitude[a]), y(path.depth[a]));
    pen.lineTo(x(-rotation.lag[b] + rotation.amplitude[b]), y(path.depth[b]));
    pen.lineTo(x(-rotation.lag[b] - rotation.amplitude[b]), y(path.depth[b]));
    pen.fill();
  }
  pen.globalAlpha = 1;
  for (let k = 1; k < path.depth.length; k++) {
    line(pen, [[x(-rotation.lag[k - 1]), y(path.depth[k - 1])], [x(-rotation.lag[k]), y(path.depth[k])]],
      zone(0.5 * (path.depth[k - 1] + path.depth[k]), rotation, c), 2.5);
  }
}

function zones(pen, c, path, rotation, width, height, labels) {
  const most = path.depth[path.depth.length - 1];
  const known = rotation.rocked_to !== null && rotation.rocked_to !== undefined;
  const from = (a, b) => known ? ` ${Math.round(a)}–${Math.round(b)} ${labels.length}` : "";
  const still = known && rotation.reactive_from > rotation.rocked_to;
  const entries = [
    [`● rocked${from(0, rotation.rocked_to)}`, c.rocked],
    [still ? `● still${from(rotation.rocked_to, rotation.reactive_from)}` : "● still: none", c.still],
    [`● reactive${from(rotation.reactive_from, most)}`, c.reactive],
  ];
  legend(pen, entries, width, height - 9);
}
