// Three canvases that are drawn once per animation frame at most, and not at all while nobody looks.
import { History, drawAlong, drawDial, drawStrips } from "slider-drilling-live";

export default {
  template: `
    <div class="sd-instruments">
      <figure class="sd-panel"><figcaption>toolface, deg</figcaption><canvas ref="dial" class="sd-dial"></canvas></figure>
      <figure class="sd-panel"><canvas ref="strips" class="sd-strips"></canvas></figure>
      <figure class="sd-panel"><canvas ref="along" class="sd-along"></canvas></figure>
    </div>`,
  props: { window: Number, most: Number },
  mounted() {
    this.history = new History(this.window, this.most);
    this.hole = null;
    this.latest = null;
    this.frames = 0;
    this.waiting = false;
    this.watcher = new ResizeObserver(() => this.ask());
    this.watcher.observe(this.$el);
    this.dark = new MutationObserver(() => this.ask());
    this.dark.observe(document.body, { attributes: true, attributeFilter: ["class"] });
    this.ask();
  },
  beforeUnmount() {
    this.watcher.disconnect();
    this.dark.disconnect();
  },
  methods: {
    begin(hole) {
      this.hole = hole;
    },
    frame(data) {
      this.history.add(data.rows);
      this.latest = data;
      this.frames += 1;
      this.$el.dataset.frames = this.frames;
      this.$el.dataset.rows = this.history.rows.length;
      this.ask();
    },
    ask() {
      if (this.waiting) return;
      this.waiting = true;
      requestAnimationFrame(() => {
        this.waiting = false;
        this.draw();
      });
    },
    draw() {
      if (!this.$refs.dial) return;
      const none = { target: null, estimate: null, spread: null, measured: [], truth: null };
      drawDial(this.$refs.dial, this.latest ? this.latest.dial : none);
      drawStrips(this.$refs.strips, this.history, this.latest ? this.latest.rocking : null);
      drawAlong(this.$refs.along, this.hole, this.latest ? this.latest.turning : {});
    },
  },
};
