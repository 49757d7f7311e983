// A canvas that follows its element's size, and the page's colours, light and dark.

export function colours() {
  const dark = document.body.classList.contains("body--dark");
  return {
    paper: dark ? "#121212" : "#ffffff",
    text: dark ? "#e6e9ee" : "#1c2733",
    faint: dark ? "#9aa5b1" : "#53606e",
    grid: dark ? "#38424e" : "#d9dfe6",
    rocked: dark ? "#56b4e9" : "#0072b2",
    still: dark ? "#8b95a1" : "#8b95a1",
    reactive: dark ? "#ff9d5c" : "#d55e00",
    target: dark ? "#2fd3a0" : "#009e73",
    estimate: dark ? "#56b4e9" : "#0072b2",
    measured: dark ? "#ffd166" : "#b15c00",
    truth: dark ? "#c9d1da" : "#444c55",
    hook: dark ? "#f0e442" : "#7a5195",
    expected: dark ? "#9b5d84" : "#e8a0c8",
    expectedText: dark ? "#ff8fc8" : "#b3387f",
    threshold: dark ? "#ffb14d" : "#b35c00",
    bad: dark ? "#ff7b72" : "#c62828",
  };
}

// Clear a canvas and prepare it for CSS pixels; null while the element has no size.
export function begin(canvas) {
  const width = canvas.clientWidth, height = canvas.clientHeight;
  if (width < 40 || height < 40) return null;
  const ratio = window.devicePixelRatio || 1;
  const w = Math.round(width * ratio), h = Math.round(height * ratio);
  if (canvas.width !== w || canvas.height !== h) {
    canvas.width = w;
    canvas.height = h;
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  return { pen, width, height, colours: colours() };
}

export function text(pen, label, x, y, { size = 12, colour, align = "left", base = "middle", bold = false } = {}) {
  pen.font = `${bold ? "600 " : ""}${size}px system-ui, sans-serif`;
  pen.textAlign = align;
  pen.textBaseline = base;
  if (colour) pen.fillStyle = colour;
  pen.fillText(label, x, y);
}

export function line(pen, points, colour, width = 1.5, dash = []) {
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.setLineDash(dash);
  pen.beginPath();
  let down = false;
  for (const [x, y] of points) {
    if (x === null || y === null) { down = false; continue; }
    if (down) pen.lineTo(x, y); else pen.moveTo(x, y);
    down = true;
  }
  pen.stroke();
  pen.setLineDash([]);
}

// Round numbers, about `count` of them and at least two, within a range: one alone shows no scale.
export function ticks(low, high, count) {
  const raw = (high - low) / Math.max(count, 1);
  const power = Math.pow(10, Math.floor(Math.log10(raw)));
  const sizes = [10, 5, 2, 1].map((k) => k * power), widest = sizes.findLastIndex((size) => size >= raw);
  const tried = sizes.slice(Math.max(widest, 0)).map((step) => multiples(step, low, high));
  return tried.find((values) => values.length > 1) ?? tried[tried.length - 1];
}

function multiples(step, low, high) {
  const values = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) values.push(k * step);
  return values.map((value) => Math.abs(value) < 1e-9 * step ? 0 : value);
}

// Draw entries (label, colour) on one line, in a smaller font if they do not fit.
export function legend(pen, entries, width, y) {
  const gap = 14;
  let size = 11.5, widths, total;
  do {
    size -= 0.5;
    pen.font = `${size}px system-ui, sans-serif`;
    widths = entries.map(([label]) => pen.measureText(label).width);
    total = widths.reduce((sum, size) => sum + size, gap * (entries.length - 1));
  } while (total > width - 4 && size > 8);
  let x = Math.max((width - total) / 2, 2);
  entries.forEach(([label, colour], k) => {
    text(pen, label, x, y, { size, colour });
    x += widths[k] + gap;
  });
}
