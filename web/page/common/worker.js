// A worker of the pool (pool.js): an instance of the module that does what it is told, one call after the other.
import { Engine } from "./engine.js";

let engine = null;

self.onmessage = async ({ data }) => {
  if (data.module) {
    try {
      engine = await Engine.of(data.module);
      self.postMessage({ ready: true });
    } catch (error) {
      self.postMessage({ ready: false, error: error.message });
    }
    return;
  }
  const began = performance.now();
  try {
    const answer = engine.call(data.name, data.argument);
    self.postMessage({ answer, ms: performance.now() - began }, [answer.buffer]);
  } catch (error) {
    self.postMessage({ error: error.message, fatal: error.fatal === true });
  }
};
