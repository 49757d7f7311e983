export { drawDial } from "./dial.js";
export { History, drawStrips } from "./strips.js";
export { drawString } from "./string_view.js";
export { drawGaps, drawTimeLine, drawTrends } from "./twin_view.js";
