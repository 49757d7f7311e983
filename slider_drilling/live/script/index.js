export { drawDial } from "./dial.js";
export { History, drawStrips } from "./strips.js";
export { drawAlong } from "./along.js";
