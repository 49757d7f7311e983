// Three canvases that are drawn once per animation frame at most, and not while the page is hidden.
import { History, drawString, drawDial, drawStrips } from "slider-drilling-live";

export default {
  template: `
    <div class="sd-instruments">
      <figure class="sd-panel"><figcaption>toolface, deg</figcaption><canvas ref="dial" class="sd-dial"></canvas></figure>
      <figure class="sd-panel"><canvas ref="strips" class="sd-strips"></canvas></figure>
      <figure class="sd-panel"><canvas ref="string" class="sd-string"></canvas></figure>
    </div>`,
  props: { window: Number, maxSamples: Number, labels: Object },
  mounted() {
    this.history = new History(this.window, this.maxSamples);
    this.wellPath = null;
    this.latest = null;
    this.frames = 0;
    this.isRequested = false;
    this.watcher = new ResizeObserver(() => this.requestDraw());
    this.watcher.observe(this.$el);
    this.dark = new MutationObserver(() => this.requestDraw());
    this.dark.observe(document.body, { attributes: true, attributeFilter: ["class"] });
    this.requestDraw();
    this.lastWord = performance.now();
    this.clock = setInterval(() => this.showSilence(), 500);
  },
  beforeUnmount() {
    clearInterval(this.clock);
    this.watcher.disconnect();
    this.dark.disconnect();
  },
  methods: {
    showWellPath(path) {
      this.wellPath = path;
    },
    // The server speaks once a second: a page whose server hangs must not look alive.
    keepAlive() {
      this.lastWord = performance.now();
      this.showSilence();
    },
    showSilence() {
      const silence = (performance.now() - this.lastWord) / 1000;
      document.body.classList.toggle("sd-server-late", silence > 2);
      document.body.classList.toggle("sd-server-lost", silence > 5);
      document.body.dataset.silence = silence > 5 ? `no data from the page's server for ${Math.round(silence)} s` : "";
    },
    drawFrame(data) {
      this.history.add(data.samples, data.expected, data.dial.measured);
      this.latest = data;
      this.frames += 1;
      this.$el.dataset.frames = this.frames;
      this.$el.dataset.samples = this.history.samples.length;
      this.requestDraw();
    },
    requestDraw() {
      if (this.isRequested) return;
      this.isRequested = true;
      requestAnimationFrame(() => {
        this.isRequested = false;
        this.draw();
      });
    },
    draw() {
      if (!this.$refs.dial) return;
      const none = { target: null, estimate: null, spread: null, measured: [], truth: null };
      drawDial(this.$refs.dial, this.latest ? this.latest.dial : none);
      drawStrips(this.$refs.strips, this.history, this.latest ? this.latest.rocking : null, this.labels);
      drawString(this.$refs.string, this.wellPath, this.latest ? this.latest.rotation : {}, this.labels);
    },
  },
};
