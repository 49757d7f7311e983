"use strict";
// Draws the page's figures in the theme the reader has, and once more for paper.
(async () => {
  const PAPER = { width: 700, half: 340, height: 900, scale: 0.82 };  // px within the margins of A4 and of letter
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const touch = matchMedia("(pointer: coarse)").matches;
  const plots = [...document.querySelectorAll(".plot")];

  async function unpacked(id) {
    const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), c => c.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  }

  let drawings;
  try {
    const script = document.createElement("script");
    script.textContent = await unpacked("plotly");
    document.head.append(script);
    drawings = await unpacked("drawings");
  } catch (error) {
    for (const plot of plots) plot.textContent = `This browser cannot draw the figure (${error.message}); one of 2023 or later can.`;
    return;
  }

  const hidden = plots.map(() => new Map());
  for (const legend of document.querySelectorAll(".legend")) {
    for (const button of legend.querySelectorAll("button")) {
      hidden[legend.dataset.place].set(button.dataset.name, button.getAttribute("aria-pressed") === "false");
    }
  }

  function themed(name) {
    const colours = THEMES[name];
    return JSON.parse(drawings.replace(/"@([a-z]+)([0-9a-f]{2})?"/g, (_, colour, alpha) => `"${colours[colour]}${alpha ?? ""}"`));
  }

  function laidOut(figure, name, width, paper) {
    const rule = name === "dark" ? "#33404c" : "#e0e6ec", ink = THEMES[name].ink;
    const layout = figure.layout;
    for (const key of Object.keys(layout)) {
      if (!/^[xy]axis/.test(key)) continue;
      Object.assign(layout[key], { gridcolor: rule, linecolor: rule, zerolinecolor: rule, zerolinewidth: 1.5, exponentformat: "power",
        hoverformat: ".7~g" });
    }
    let above = 30;
    for (const note of layout.annotations ?? []) {  // a heading that is wider than the figure takes two lines
      if (note.text.length * 6 <= width - 46 || !note.text.includes(" · ")) continue;
      note.text = note.text.replace(" · ", "<br>");
      above = 46;
    }
    return Object.assign(layout, {
      width, height: paper ? Math.min(figure.height * (width > PAPER.half ? PAPER.scale : PAPER.scale * PAPER.scale), PAPER.height) : figure.height, autosize: false, showlegend: false, paper_bgcolor: "rgba(0,0,0,0)",
      plot_bgcolor: "rgba(0,0,0,0)", font: { color: ink, size: width < 460 ? 11 : 12.5, family: "system-ui, sans-serif" },
      margin: { l: 46, r: 12, t: above, b: 40 }, hoverlabel: { bgcolor: name === "dark" ? "#1d242c" : "#ffffff", font: { color: ink } }, separators: ".\u2009", dragmode: touch ? false : "zoom",
    });
  }

  // Two narrow figures stand side by side on paper.
  function paperWidth(plot) {
    const figure = plot.closest("figure");
    const narrow = [...figure.parentElement.children].filter(one => !one.classList.contains("wide"));
    return narrow.includes(figure) && narrow.length > 1 ? PAPER.half : PAPER.width;
  }

  function draw(name, paper) {
    const figures = themed(name);
    for (const plot of plots) {
      if (plot.closest("details:not([open])")) continue;  // folded away, on paper too
      const place = plot.dataset.place, figure = figures[place];
      for (const trace of figure.data) {
        if (hidden[place].has(trace.name)) trace.visible = hidden[place].get(trace.name) ? "legendonly" : true;
      }
      Plotly.react(plot, figure.data, laidOut(figure, name, paper ? paperWidth(plot) : plot.clientWidth, paper), {
        displaylogo: false, displayModeBar: touch ? false : "hover",
        modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d", "zoomIn2d", "zoomOut2d"],
      });
      plot.style.minHeight = "";
    }
  }
  const screen = () => draw(dark.matches ? "dark" : "light", false);

  let last = 0, waiting = 0;
  addEventListener("resize", () => {
    clearTimeout(waiting);
    waiting = setTimeout(() => { if (innerWidth !== last) { last = innerWidth; screen(); } }, 120);
  });
  dark.addEventListener("change", screen);
  addEventListener("beforeprint", () => draw("light", true));
  addEventListener("afterprint", screen);
  for (const part of document.querySelectorAll("details")) part.addEventListener("toggle", screen);
  for (const legend of document.querySelectorAll(".legend")) {
    legend.addEventListener("click", event => {
      const button = event.target.closest("button"), place = legend.dataset.place;
      if (!button) return;
      const off = !hidden[place].get(button.dataset.name);
      hidden[place].set(button.dataset.name, off);
      button.setAttribute("aria-pressed", String(!off));
      const plot = document.querySelector(`.plot[data-place="${place}"]`);
      const traces = plot.data.map((trace, index) => (trace.name === button.dataset.name ? index : -1)).filter(index => index >= 0);
      Plotly.restyle(plot, { visible: off ? "legendonly" : true }, traces);
    });
  }
  last = innerWidth;
  screen();
  document.documentElement.dataset.drawn = "yes";
})();
