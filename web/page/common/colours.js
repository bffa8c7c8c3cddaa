// Colours of regimes and series: those of the program's pictures (host-sim/src/pictures/regimes.rs, host-sim/plot/src/palette.rs;
// a test there holds this list to them). They stay apart for readers who do not see red or green.

export const REGIMES = [
  ["1/1", "#0072B2"],
  ["2/2", "#009E73"],
  ["4/4", "#9AE0C4"],
  ["1/2", "#E69F00"],
  ["2/4", "#FBE0A0"],
  ["1/3", "#F0E442"],
  ["1/4", "#A8A21E"],
  ["2/1", "#882255"],
  ["3/1", "#B85CC0"],
  ["3/2", "#332288"],
  ["other p/n", "#C9B8F0"],
  ["aperiodic", "#383838"],
  ["unsettled", "#905010"],
  ["chatter", "#CC79A7"],
  ["none", "#E8E8E8"],
];

const BY_NAME = new Map(REGIMES.map(([name, colour], index) => [name, { index, colour }]));

// Under which name of REGIMES a regime stands.
export function regimeGroup(regime) {
  if (BY_NAME.has(regime)) return regime;
  return /^\d+\/\d+$/.test(regime) ? "other p/n" : "none";
}

// Its place in REGIMES.
export function regimeIndex(regime) {
  return BY_NAME.get(regimeGroup(regime)).index;
}

// What a legend calls it.
export function regimeWords(regime) {
  return regime === "none" ? "no contact" : regime;
}

// Its colour.
export function regimeColour(regime) {
  return BY_NAME.get(regimeGroup(regime)).colour;
}

// The colours of series without a meaning of their own.
export const SERIES = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"];
