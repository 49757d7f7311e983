// Strip charts over the last minutes. The history is trimmed to its window with every frame: it does not grow.
import { begin, line, text, ticks } from "./paint.js";

const LEFT = 46, RIGHT = 8, TOP = 20, BOTTOM = 16;
const KEPT_TOOL_FACES = 100;

export class History {
  constructor(window, maxSamples) {
    this.window = window;
    this.maxSamples = maxSamples;
    this.samples = [];
    this.expected = [];
    this.toolFaces = [];
  }

  // samples: what the rig measured; expected: what a twin expects; measured: [age s, deg] of MWD toolfaces.
  add(samples, expected, measured) {
    this.samples = this.extended(this.samples, samples);
    if (!this.samples.length) return;
    const now = this.samples[this.samples.length - 1][0];
    this.expected = this.extended(this.expected, expected).filter((sample) => sample[0] <= now + 1);
    this.toolFaces = measured.slice(-KEPT_TOOL_FACES).map(([age, deg]) => [now - age, deg]);
  }

  extended(kept, fresh) {
    for (const sample of fresh) {
      if (kept.length && sample[0] < kept[kept.length - 1][0]) kept = [];
      kept.push(sample);
    }
    if (!kept.length) return kept;
    const since = kept[kept.length - 1][0] - this.window;
    let first = Math.max(kept.length - this.maxSamples, 0);
    while (kept[first][0] < since) first++;
    if (first) kept.splice(0, first);
    return kept;
  }
}

export function drawStrips(canvas, history, rocking, labels) {
  const sheet = begin(canvas);
  if (!sheet) return;
  const { pen, width, height, colours: c } = sheet;
  const samples = history.samples;
  const now = samples.length ? samples[samples.length - 1][0] : 0;
  const span = [now - history.window, now];
  const strips = [
    { column: 1, over: 1, title: labels.strips[0], colour: c.rocked, digits: labels.digits[0], zero: true },
    { column: 2, over: 2, title: labels.strips[1], colour: c.reactive, digits: labels.digits[1], zero: true },
    { column: 3, over: 3, title: labels.strips[2], colour: c.hook, digits: labels.digits[2] },
    { column: 4, title: labels.strips[3], colour: c.truth, digits: labels.digits[3], rocking },
    { dots: history.toolFaces, over: 4, title: "MWD toolface, deg", colour: c.measured, digits: 0, turns: true },
  ];
  const tall = (height - BOTTOM) / strips.length;
  strips.forEach((strip, k) => drawStrip(pen, c, history, span, strip, width, k * tall, tall));
  for (const back of ticks(0, history.window, width < 420 ? 3 : 5)) {
    const x = LEFT + (1 - back / history.window) * (width - LEFT - RIGHT);
    text(pen, back ? `-${back} s` : "now", x, height - 7,
      { size: 10, colour: c.faint, align: back ? (back === history.window ? "left" : "center") : "right" });
  }
}

// The points of a strip: [time, value], measured and expected.
function pointsOf(history, strip, span) {
  const pick = (rows, column) => rows.filter((row) => row[0] >= span[0]).map((row) => [row[0], row[column]]);
  const measured = strip.dots ? strip.dots.filter((dot) => dot[0] >= span[0]) : pick(history.samples, strip.column);
  return [measured, strip.over ? pick(history.expected, strip.over) : []];
}

// Lowest and highest value of both; null without one. Angles of a full turn get its whole range.
function rangeOf(points, strip) {
  let low = strip.zero ? 0 : Infinity, high = strip.zero ? 0 : -Infinity;
  for (const [, value] of points) {
    if (value === null) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  if (low > high) return null;
  if (strip.turns && high - low > 180) return [-180, 180];
  const least = strip.turns ? 20 : 1e-6;
  if (high - low < least) { low -= strip.turns ? 10 : 1; high += strip.turns ? 10 : 1; }
  const room = 0.06 * (high - low);
  return [low - room, high + room];
}

function drawStrip(pen, c, history, span, strip, width, top, tall) {
  const [measured, expected] = pointsOf(history, strip, span);
  const known = measured.filter((point) => point[1] !== null);
  const shown = strip.dots ? known : measured;  // a line that has ended has no value now
  const last = shown.length ? shown[shown.length - 1][1] : null;
  text(pen, strip.title, LEFT, top + 11, { size: 12, colour: c.faint });
  if (expected.some((point) => point[1] !== null)) {
    text(pen, "— expected", LEFT + 12 + pen.measureText(strip.title).width, top + 11, { size: 12, colour: c.expectedText });
  }
  text(pen, last === null ? "–" : last.toFixed(strip.digits), width - RIGHT, top + 11,
    { size: 16, colour: strip.colour, align: "right", bold: true });
  const range = rangeOf([...measured, ...expected], strip);
  if (range === null) return;
  const [low, high] = range;
  const y = (value) => top + tall - 4 - (value - low) / (high - low) * (tall - TOP - 6);
  const x = (time) => LEFT + (time - span[0]) / (span[1] - span[0]) * (width - LEFT - RIGHT);
  for (const tick of ticks(low, high, tall > 110 ? 4 : 3)) {
    line(pen, [[LEFT, y(tick)], [width - RIGHT, y(tick)]], c.grid, tick === 0 ? 1.4 : 0.7);
    text(pen, String(+tick.toFixed(6)), LEFT - 5, y(tick), { size: 10, colour: c.faint, align: "right" });
  }
  drawRocking(pen, c, strip.rocking, y, width);
  pen.save();
  pen.beginPath();
  pen.rect(LEFT, top, width - LEFT - RIGHT, tall);
  pen.clip();
  const place = ([time, value]) => [x(time), value === null ? null : y(value)];
  line(pen, unbroken(expected, strip.turns).map(place), c.expected, 2.6);
  if (strip.dots) drawDots(pen, known.map(place), strip.colour);
  else line(pen, measured.map(place), strip.colour, 1.2);
  pen.restore();
}

function drawRocking(pen, c, rocking, y, width) {
  if (!rocking || rocking.centre === null) return;
  const { centre, amplitude } = rocking;
  line(pen, [[LEFT, y(centre)], [width - RIGHT, y(centre)]], c.target, 1.2, [6, 4]);
  if (amplitude === null) return;
  pen.globalAlpha = 0.1;
  pen.fillStyle = c.target;
  pen.fillRect(LEFT, y(centre + amplitude), width - LEFT - RIGHT, y(centre - amplitude) - y(centre + amplitude));
  pen.globalAlpha = 1;
}

function drawDots(pen, places, colour) {
  pen.fillStyle = colour;
  for (const [x, y] of places) {
    pen.beginPath();
    pen.arc(x, y, 3, 0, 2 * Math.PI);
    pen.fill();
  }
}

// The line is broken where an angle goes on at the other end of the turn.
function unbroken(points, turns) {
  if (!turns) return points;
  const parts = [];
  points.forEach(([time, value], k) => {
    const before = k ? points[k - 1][1] : null;
    if (value !== null && before !== null && Math.abs(value - before) > 180) parts.push([time, null]);
    parts.push([time, value]);
  });
  return parts;
}
