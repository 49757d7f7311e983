// The toolface dial: 0 deg (high side) on top, clockwise positive, as on a driller's display.
import { begin, legend, text } from "./paint.js";

const FADE_TIME = 240; // s after which a measured toolface is no longer drawn

export function drawDial(canvas, dial) {
  const sheet = begin(canvas);
  if (!sheet) return;
  const { pen, width, height, colours: c } = sheet;
  const x = width / 2, y = (height - 22) / 2, r = Math.min(x, y) - 24;
  const at = (deg, radius) => {
    const a = (deg - 90) * Math.PI / 180;
    return [x + radius * Math.cos(a), y + radius * Math.sin(a)];
  };
  pen.lineWidth = 1.2;
  pen.strokeStyle = c.grid;
  for (const share of [1, 0.7, 0.4]) {
    pen.beginPath();
    pen.arc(x, y, share * r, 0, 2 * Math.PI);
    pen.stroke();
  }
  for (let deg = -180; deg < 180; deg += 30) {
    pen.beginPath();
    pen.moveTo(...at(deg, r));
    pen.lineTo(...at(deg, r - (deg % 90 ? 6 : 12)));
    pen.strokeStyle = c.faint;
    pen.stroke();
    text(pen, deg === -180 ? "180" : String(deg), ...at(deg, r + 13), { size: 11, colour: c.faint, align: "center" });
  }
  if (dial.estimate !== null && dial.spread !== null) {
    for (const [sigmas, alpha] of [[2, 0.13], [1, 0.25]]) {
      const half = Math.min(sigmas * dial.spread, 180);
      pen.globalAlpha = alpha;
      pen.fillStyle = c.estimate;
      pen.beginPath();
      pen.moveTo(x, y);
      pen.arc(x, y, r, (dial.estimate - half - 90) * Math.PI / 180, (dial.estimate + half - 90) * Math.PI / 180);
      pen.closePath();
      pen.fill();
    }
    pen.globalAlpha = 1;
    drawNeedle(pen, at, dial.estimate, r, c.estimate, 3);
  }
  for (const [age, deg] of dial.measured) {
    if (deg === null || age > FADE_TIME) continue;
    pen.globalAlpha = 0.08 + 0.92 * (1 - age / FADE_TIME);
    pen.fillStyle = c.measured;
    pen.beginPath();
    pen.arc(...at(deg, r * (1 - 0.6 * age / FADE_TIME)), age < 15 ? 6 : 4.5, 0, 2 * Math.PI);
    pen.fill();
  }
  pen.globalAlpha = 1;
  if (dial.truth !== null) {
    pen.strokeStyle = c.truth;
    pen.lineWidth = 2;
    pen.beginPath();
    pen.arc(...at(dial.truth, r), 7, 0, 2 * Math.PI);
    pen.stroke();
  }
  if (dial.target !== null) drawTarget(pen, at, dial.target, r, c);
  const entries = [["● target", c.target], ["● estimate ±1, 2 σ", c.estimate], ["● MWD", c.measured]];
  if (dial.truth !== null) entries.push(["○ truth", c.truth]);
  legend(pen, entries, width, height - 9);
}

function drawNeedle(pen, at, deg, r, colour, width) {
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.beginPath();
  pen.moveTo(...at(deg, 0));
  pen.lineTo(...at(deg, r));
  pen.stroke();
}

// The target: a wedge across the ring, so that no dot hides it.
function drawTarget(pen, at, deg, r, c) {
  pen.beginPath();
  pen.moveTo(...at(deg, r - 14));
  pen.lineTo(...at(deg - 5, r + 4));
  pen.lineTo(...at(deg + 5, r + 4));
  pen.closePath();
  pen.fillStyle = c.target;
  pen.fill();
  pen.strokeStyle = c.paper;
  pen.lineWidth = 1.5;
  pen.stroke();
}
