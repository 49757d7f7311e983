// The string along its hole, coloured by zone, and beside it how far each depth turns.
import { begin, legend, line, text, ticks } from "./paint.js";

export function drawAlong(canvas, hole, turning) {
  const sheet = begin(canvas);
  if (!sheet) return;
  const { pen, width, height, colours: c } = sheet;
  if (!hole) {
    text(pen, "no rig file has come yet", width / 2, height / 2, { size: 13, colour: c.faint, align: "center" });
    return;
  }
  const stacked = width < 420;
  const section = stacked ? [0, 0, width, 0.5 * height - 12] : [0, 0, 0.54 * width, height - 24];
  const twist = stacked ? [0, 0.5 * height - 6, width, 0.5 * height - 18] : [0.54 * width, 0, 0.46 * width, height - 24];
  drawSection(pen, c, hole, turning, section);
  drawTwist(pen, c, hole, turning, twist);
  zones(pen, c, hole, turning, width, height);
}

function zone(depth, turning, c) {
  if (turning.rocked_to === null || turning.rocked_to === undefined) return c.still;
  if (depth <= turning.rocked_to) return c.rocked;
  return depth >= turning.reactive_from ? c.reactive : c.still;
}

function drawSection(pen, c, hole, turning, [left, top, wide, tall]) {
  const reach = Math.max(...hole.away, 1), deep = Math.max(...hole.down, 1);
  const scale = Math.min((wide - 74) / reach, (tall - 46) / deep);
  const x = (away) => left + 48 + away * scale, y = (down) => top + 24 + down * scale;
  text(pen, "vertical section, m", left + 6, top + 10, { colour: c.faint });
  for (const tick of ticks(0, deep, 4)) {
    line(pen, [[x(0), y(tick)], [x(reach), y(tick)]], c.grid, 0.7);
    text(pen, String(tick), x(0) - 6, y(tick), { size: 10, colour: c.faint, align: "right" });
  }
  for (const tick of ticks(0, reach, 3).slice(1)) {
    text(pen, String(tick), x(tick), y(deep) + 12, { size: 10, colour: c.faint, align: "center" });
  }
  for (let k = 1; k < hole.depth.length; k++) {
    const middle = 0.5 * (hole.depth[k - 1] + hole.depth[k]);
    line(pen, [[x(hole.away[k - 1]), y(hole.down[k - 1])], [x(hole.away[k]), y(hole.down[k])]],
      zone(middle, turning, c), 5);
  }
  const end = hole.depth.length - 1;
  pen.fillStyle = c.text;
  pen.beginPath();
  pen.arc(x(hole.away[end]), y(hole.down[end]), 4.5, 0, 2 * Math.PI);
  pen.fill();
}

function drawTwist(pen, c, hole, turning, [left, top, wide, tall]) {
  text(pen, "turn about the centre, rad", left + 10, top + 10, { colour: c.faint });
  if (!turning.swing) return;
  const low = Math.min(...turning.swing.map((swing, k) => -turning.behind[k] - swing));
  const high = Math.max(...turning.swing.map((swing, k) => swing - turning.behind[k]), 0);
  const most = hole.depth[hole.depth.length - 1], span = Math.max(high - low, 0.5);
  const x = (turn) => left + 24 + (turn - low) / span * (wide - 40);
  const y = (depth) => top + 24 + depth / most * (tall - 46);
  for (const tick of ticks(low, low + span, 4)) {
    line(pen, [[x(tick), y(0)], [x(tick), y(most)]], c.grid, tick === 0 ? 1.4 : 0.7);
    text(pen, String(+tick.toFixed(3)), x(tick), y(most) + 11, { size: 10, colour: c.faint, align: "center" });
  }
  pen.globalAlpha = 0.22;
  for (let k = 1; k < hole.depth.length; k++) {
    if (!turning.swing[k - 1]) continue;
    const [a, b] = [k - 1, k];
    pen.fillStyle = zone(0.5 * (hole.depth[a] + hole.depth[b]), turning, c);
    pen.beginPath();
    pen.moveTo(x(-turning.behind[a] - turning.swing[a]), y(hole.depth[a]));
    pen.lineTo(x(-turning.behind[a] + turning.swing[a]), y(hole.depth[a]));
    pen.lineTo(x(-turning.behind[b] + turning.swing[b]), y(hole.depth[b]));
    pen.lineTo(x(-turning.behind[b] - turning.swing[b]), y(hole.depth[b]));
    pen.fill();
  }
  pen.globalAlpha = 1;
  for (let k = 1; k < hole.depth.length; k++) {
    line(pen, [[x(-turning.behind[k - 1]), y(hole.depth[k - 1])], [x(-turning.behind[k]), y(hole.depth[k])]],
      zone(0.5 * (hole.depth[k - 1] + hole.depth[k]), turning, c), 2.5);
  }
}

function zones(pen, c, hole, turning, width, height) {
  const most = hole.depth[hole.depth.length - 1];
  const known = turning.rocked_to !== null && turning.rocked_to !== undefined;
  const from = (a, b) => known ? ` ${Math.round(a)}–${Math.round(b)} m` : "";
  const still = known && turning.reactive_from > turning.rocked_to;
  const entries = [
    [`● rocked${from(0, turning.rocked_to)}`, c.rocked],
    [still ? `● still${from(turning.rocked_to, turning.reactive_from)}` : "● still: none", c.still],
    [`● reactive${from(turning.reactive_from, most)}`, c.reactive],
  ];
  legend(pen, entries, width, height - 9);
}
