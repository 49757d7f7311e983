// What a twin says: the gap of each channel against its threshold, detections over time, calibrated parameters.
import { begin, legend, line, text, ticks } from "./paint.js";

// The gap over 60 s as a bar, over 10 and 300 s as ticks, in units of the channel's own threshold.
export function drawGaps(canvas, gaps) {
  const sheet = begin(canvas);
  if (!sheet) return;
  const { pen, width, height, colours: c } = sheet;
  if (!gaps.length) return text(pen, "no gap yet", width / 2, height / 2, { size: 13, colour: c.faint, align: "center" });
  const left = 8, right = width - 8, bottom = 38, row = Math.min((height - bottom - 4) / gaps.length, 62);
  const most = Math.max(2, ...gaps.map((gap) => 1.08 * (gap.share ?? 0)));
  const x = (share) => left + Math.min(share, most) / most * (right - left);
  gaps.forEach((gap, k) => {
    const top = 6 + k * row, base = top + 18, tall = Math.max(row - 30, 8), over = gap.share > 1;
    text(pen, gap.name, left, top + 9, { size: 12, colour: c.text });
    text(pen, gap.shown, right, top + 9, { size: 12, colour: over ? c.bad : c.text, align: "right", bold: over });
    pen.fillStyle = c.grid;
    pen.fillRect(left, base, right - left, tall);
    if (gap.share !== null) {
      pen.fillStyle = over ? c.bad : c.rocked;
      pen.fillRect(left, base, x(gap.share) - left, tall);
    }
    for (const [share, dash] of [[gap.quick, [2, 2]], [gap.slow, []]]) {
      if (share !== null) line(pen, [[x(share), base - 3], [x(share), base + tall + 3]], c.text, 1.2, dash);
    }
    if (gap.share !== null) line(pen, [[x(1), base - 4], [x(1), base + tall + 4]], c.threshold, 2.2);
  });
  text(pen, "▮ 60 s   ┆ 10 s   │ 300 s", left, height - 25, { size: 11, colour: c.faint });
  text(pen, "│ threshold", left, height - 9, { size: 11, colour: c.threshold });
}

// Detections as bars from their onset on, newest on top; the thick part is the interval of the onset.
export function drawTimeLine(canvas, twin) {
  const sheet = begin(canvas);
  if (!sheet) return;
  const { pen, width, height, colours: c } = sheet;
  const left = 10, right = width - 10, bottom = 20, top = 6;
  const rows = twin.detections.slice(-Math.max(Math.floor((height - bottom - top) / 38), 1)).reverse();
  const starts = rows.map((one) => one.interval[0]);
  const first = Math.min(twin.start ?? twin.now - 60, ...starts, twin.now - 60), now = twin.now;
  const x = (time) => left + (Math.max(time, first) - first) / (now - first) * (right - left);
  for (const back of ticks(0, (now - first) / 60, 4)) {
    const at = x(now - 60 * back);
    line(pen, [[at, top], [at, height - bottom]], c.grid, 0.7);
    text(pen, back ? `-${+back.toFixed(3)} min` : "now", at, height - 9,
      { size: 10, colour: c.faint, align: back ? (at < left + 24 ? "left" : "center") : "right" });
  }
  if (!rows.length) {
    return text(pen, twin.compared ? "no change detected" : "not compared yet", (left + right) / 2, height / 2 - 10, { size: 13, colour: c.faint, align: "center" });
  }
  rows.forEach((one, k) => drawDetection(pen, c, one, x, now, top + k * 38, left, right));
  if (twin.detections.length > rows.length) {
    text(pen, `${twin.detections.length - rows.length} earlier ones`, left, height - bottom - 4, { size: 10, colour: c.faint });
  }
}

function drawDetection(pen, c, one, x, now, top, left, right) {
  const colour = one.ended ? c.faint : one.named ? c.bad : c.threshold, y = top + 25;
  line(pen, [[x(one.since), y], [x(one.ended ?? now), y]], colour, 3);
  pen.globalAlpha = 0.35;
  line(pen, [[x(one.interval[0]), y], [Math.max(x(one.interval[1]), x(one.interval[0]) + 2), y]], colour, 11);
  pen.globalAlpha = 1;
  line(pen, [[x(one.detected), y - 6], [x(one.detected), y + 6]], c.text, 1.4);
  pen.font = "12px system-ui, sans-serif";
  let label = one.label;
  while (pen.measureText(label).width > right - left && label.length > 4) label = `${label.slice(0, -2).trimEnd()}…`;
  const wide = pen.measureText(label).width;
  text(pen, label, Math.min(x(one.since), right - wide), top + 9, { size: 12, colour });
}

// Calibrated parameters over the rig file's, the friction with its interval.
export function drawTrends(canvas, twin) {
  const sheet = begin(canvas);
  if (!sheet) return;
  const { pen, width, height, colours: c } = sheet;
  const left = 42, right = width - 10, top = 24, bottom = 20;
  const palette = [c.rocked, c.reactive, c.target, c.hook];
  const points = twin.trends.filter((trend) => trend.points.length);
  if (!points.length) {
    return text(pen, "no parameter calibrated yet", width / 2, height / 2, { size: 13, colour: c.faint, align: "center" });
  }
  legend(pen, points.map((trend, k) => [`${trend.name} ${shown(trend)}`, palette[twin.trends.indexOf(trend)]]), width, 9);
  const every = points.flatMap((trend) => trend.points.flatMap(([, v, low, high]) => trend === twin.trends[0] ? [v, low, high] : [v]));
  const known = every.filter((value) => value !== null);
  let low = Math.min(0.9, ...known), high = Math.max(1.1, ...known);
  const first = points[0].points[0][0], now = Math.max(twin.now, first + 60);
  const x = (time) => left + (time - first) / (now - first) * (right - left);
  const y = (value) => height - bottom - (value - low) / (high - low) * (height - top - bottom);
  for (const tick of ticks(low, high, 4)) {
    line(pen, [[left, y(tick)], [right, y(tick)]], c.grid, tick === 1 ? 1.6 : 0.7);
    text(pen, String(+tick.toFixed(3)), left - 5, y(tick), { size: 10, colour: c.faint, align: "right" });
  }
  for (const back of ticks(0, (now - first) / 60, 4)) {
    const at = x(now - 60 * back);
    text(pen, back ? `-${+back.toFixed(3)} min` : "now", at, height - 9,
      { size: 10, colour: c.faint, align: back ? (at < left + 24 ? "left" : "center") : "right" });
  }
  const friction = points.find((trend) => trend === twin.trends[0]);
  if (friction) drawBand(pen, friction.points.filter((point) => point[2] !== null && point[3] !== null), x, y, palette[0]);
  points.forEach((trend) => {
    line(pen, trend.points.map(([time, value]) => [x(time), value === null ? null : y(value)]), palette[twin.trends.indexOf(trend)], trend === friction ? 2.4 : 1.4);
  });
}

function shown(trend) {
  const last = trend.points[trend.points.length - 1][1];
  return last === null ? "–" : last.toFixed(2);
}

function drawBand(pen, points, x, y, colour) {
  if (points.length < 2) return;
  pen.globalAlpha = 0.2;
  pen.fillStyle = colour;
  pen.beginPath();
  points.forEach(([time, , , high], k) => k ? pen.lineTo(x(time), y(high)) : pen.moveTo(x(time), y(high)));
  [...points].reverse().forEach(([time, , low]) => pen.lineTo(x(time), y(low)));
  pen.fill();
  pen.globalAlpha = 1;
}
