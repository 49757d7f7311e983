export { drawDial } from "./dial.js";
export { History, drawStrips } from "./strips.js";
export { drawString } from "./string_view.js";
