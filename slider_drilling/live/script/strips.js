// Strip charts over the last minutes. The history is trimmed to its window with every frame: it does not grow.
import { begin, line, text, ticks } from "./paint.js";

const LEFT = 46, RIGHT = 8, TOP = 20, BOTTOM = 16;

export class History {
  constructor(window, maxSamples) {
    this.window = window;
    this.maxSamples = maxSamples;
    this.samples = [];
  }

  add(samples) {
    for (const sample of samples) {
      if (this.samples.length && sample[0] < this.samples[this.samples.length - 1][0]) this.samples = [];
      this.samples.push(sample);
    }
    if (!this.samples.length) return;
    const since = this.samples[this.samples.length - 1][0] - this.window;
    let first = Math.max(this.samples.length - this.maxSamples, 0);
    while (this.samples[first][0] < since) first++;
    if (first) this.samples.splice(0, first);
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
    { column: 1, title: labels.strips[0], colour: c.rocked, digits: labels.digits[0], zero: true },
    { column: 2, title: labels.strips[1], colour: c.reactive, digits: labels.digits[1], zero: true },
    { column: 3, title: labels.strips[2], colour: c.truth, digits: labels.digits[2], rocking },
  ];
  const tall = (height - BOTTOM) / strips.length;
  strips.forEach((strip, k) => drawStrip(pen, c, samples, span, strip, width, k * tall, tall));
  for (const back of ticks(0, history.window, width < 420 ? 3 : 5)) {
    const x = LEFT + (1 - back / history.window) * (width - LEFT - RIGHT);
    text(pen, back ? `-${back} s` : "now", x, height - 7,
      { size: 10, colour: c.faint, align: back ? (back === history.window ? "left" : "center") : "right" });
  }
}

function drawStrip(pen, c, samples, span, strip, width, top, tall) {
  let low = strip.zero ? 0 : Infinity, high = strip.zero ? 0 : -Infinity, last = null;
  for (const sample of samples) {
    const value = sample[strip.column];
    if (value === null) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
    last = value;
  }
  text(pen, strip.title, LEFT, top + 11, { size: 12, colour: c.faint });
  text(pen, last === null ? "–" : last.toFixed(strip.digits), width - RIGHT, top + 11,
    { size: 16, colour: strip.colour, align: "right", bold: true });
  if (last === null) return;
  if (high - low < 1e-6) { low -= 1; high += 1; }
  const room = 0.06 * (high - low);
  [low, high] = [low - room, high + room];
  const y = (value) => top + tall - 4 - (value - low) / (high - low) * (tall - TOP - 6);
  const x = (time) => LEFT + (time - span[0]) / (span[1] - span[0]) * (width - LEFT - RIGHT);
  for (const tick of ticks(low, high, tall > 110 ? 4 : 3)) {
    line(pen, [[LEFT, y(tick)], [width - RIGHT, y(tick)]], c.grid, tick === 0 ? 1.4 : 0.7);
    text(pen, String(+tick.toFixed(6)), LEFT - 5, y(tick), { size: 10, colour: c.faint, align: "right" });
  }
  if (strip.rocking && strip.rocking.centre !== null) {
    const { centre, amplitude } = strip.rocking;
    line(pen, [[LEFT, y(centre)], [width - RIGHT, y(centre)]], c.target, 1.2, [6, 4]);
    if (amplitude !== null) {
      pen.globalAlpha = 0.1;
      pen.fillStyle = c.target;
      pen.fillRect(LEFT, y(centre + amplitude), width - LEFT - RIGHT, y(centre - amplitude) - y(centre + amplitude));
      pen.globalAlpha = 1;
    }
  }
  pen.save();
  pen.beginPath();
  pen.rect(LEFT, top, width - LEFT - RIGHT, tall);
  pen.clip();
  line(pen, samples.map((sample) => [x(sample[0]), sample[strip.column] === null ? null : y(sample[strip.column])]), strip.colour, 1.4);
  pen.restore();
}
