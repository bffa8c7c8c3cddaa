// Explore: what the hammer does over gap and frequency, and where to run it.
import { element } from "../common/dom.js";
import { Pool } from "../common/pool.js";

export async function start(container) {
  const pool = new Pool();
  const said = element("p", { role: "status" }, "loading …");
  container.append(said);
  const { value } = await pool.json("explore.rig", { source: "wires" });
  said.textContent = `Rig ${value.name}: natural frequency ${value.natural_frequency_hz.toFixed(3)} Hz.`;
}
