// Three canvases of a twin, drawn when the twin has said something new.
import { drawGaps, drawTimeLine, drawTrends } from "slider-drilling-live";

export default {
  template: `
    <div class="sd-twin">
      <figure class="sd-panel"><figcaption>gap, noise levels</figcaption><canvas ref="gaps" class="sd-gaps"></canvas></figure>
      <figure class="sd-panel"><figcaption>changes: from their onset on</figcaption><canvas ref="line" class="sd-timeline"></canvas></figure>
      <figure class="sd-panel"><figcaption>calibrated parameters over the rig file's</figcaption><canvas ref="trends" class="sd-trends"></canvas></figure>
    </div>`,
  mounted() {
    this.latest = { now: 0, start: null, gaps: [], detections: [], trends: [] };
    this.watcher = new ResizeObserver(() => this.draw());
    this.watcher.observe(this.$el);
    this.dark = new MutationObserver(() => this.draw());
    this.dark.observe(document.body, { attributes: true, attributeFilter: ["class"] });
    this.draw();
  },
  beforeUnmount() {
    this.watcher.disconnect();
    this.dark.disconnect();
  },
  methods: {
    show(data) {
      this.latest = data;
      this.draw();
    },
    draw() {
      if (!this.$refs.gaps) return;
      drawGaps(this.$refs.gaps, this.latest.gaps);
      drawTimeLine(this.$refs.line, this.latest);
      drawTrends(this.$refs.trends, this.latest);
    },
  },
};
