// The parts of the page in the order of their tabs. Each has an id (in the address: #id?…), a title and `start(container)`.
import { start as startEmulated } from "./emulated/main.js";
import { start as startExplore } from "./explore/main.js";
import { start as startLive } from "./live/main.js";

export const parts = [
  { id: "explore", title: "Explore", start: startExplore },
  { id: "emulated", title: "Emulated rig", start: startEmulated },
  { id: "live", title: "Live", start: startLive },
];
