// The parts of the page in the order of their tabs. Each has an id (in the address: #id?…), a title and `start(container)`.
import { start as startExplore } from "./explore/main.js";

export const parts = [
  { id: "explore", title: "Explore", start: startExplore },
];
