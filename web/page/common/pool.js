// Several workers, each with its own instance of the module. Calls wait in a queue, the most urgent first; one that is
// given up before it began is dropped, one that is given up while it runs ends with its worker, which is begun anew.
import { compileModule, fromJson } from "./engine.js";

// Workers at most: beyond, a page asks for more memory than it gains in time.
const MOST = 8;

// Calls as urgent as this need not wait for long ones: one more worker does nothing else.
const URGENT = 1;

class Hand {
  constructor(pool, quick) {
    this.pool = pool;
    this.quick = quick;
    this.job = null;
    this.begin();
  }

  begin() {
    this.ready = false;
    this.worker = new Worker(this.pool.address);
    this.worker.onmessage = ({ data }) => this.heard(data);
    this.worker.onerror = (event) => this.heard({ error: event.message || "a worker failed", fatal: true });
    this.pool.module.then((module) => this.worker.postMessage({ module }), (error) => this.pool.fail(error));
  }

  heard(data) {
    if (data.ready !== undefined) {
      if (!data.ready) return this.pool.fail(new Error(data.error));
      this.ready = true;
    } else {
      const job = this.job;
      this.job = null;
      if (data.fatal) this.restart();
      if (job && data.error !== undefined) job.reject(new Error(data.error));
      else if (job) job.resolve(data);
    }
    this.pool.next();
  }

  restart() {
    this.worker.onmessage = null;
    this.worker.terminate();
    this.begin();
  }

  take(job) {
    this.job = job;
    this.worker.postMessage({ name: job.name, argument: job.argument });
  }
}

export class Pool {
  constructor(count = navigator.hardwareConcurrency || 2) {
    const code = document.getElementById("worker").textContent;
    this.address = URL.createObjectURL(new Blob([code], { type: "text/javascript" }));
    this.module = compileModule();
    this.queue = [];
    this.broken = null;
    this.count = Math.max(1, Math.min(MOST, count));
    this.hands = Array.from({ length: this.count + 1 }, (_, number) => new Hand(this, number === this.count));
  }

  // Calls a function in a worker: { answer: bytes, ms: how long it took }. Smaller `order` is more urgent. When `signal`
  // aborts, the promise rejects with its reason; with `finish`, a call that has begun is let come to its end instead.
  run(name, argument, { order = 0, signal, finish = false } = {}) {
    return new Promise((resolve, reject) => {
      if (signal?.aborted) return reject(signal.reason);
      if (this.broken) return reject(this.broken);
      const job = { name, argument, order, resolve, reject };
      signal?.addEventListener("abort", () => this.drop(job, signal.reason, finish), { once: true });
      const at = this.queue.findIndex((other) => other.order > order);
      this.queue.splice(at < 0 ? this.queue.length : at, 0, job);
      this.next();
    });
  }

  // The same with the answer read as JSON.
  async json(name, argument, options) {
    const { answer, ms } = await this.run(name, argument, options);
    return { value: fromJson(answer), ms };
  }

  drop(job, reason, finish) {
    const at = this.queue.indexOf(job);
    if (at >= 0) this.queue.splice(at, 1);
    else if (finish) return;
    const hand = this.hands.find((one) => one.job === job);
    if (hand) {
      hand.job = null;
      hand.restart();
    }
    job.reject(reason);
  }

  fail(error) {
    this.broken = error;
    for (const job of this.queue.splice(0)) job.reject(error);
  }

  next() {
    for (const hand of this.hands) {
      const first = this.queue[0];
      if (!first) return;
      // No more at once than there are processors: what is urgent has one to itself.
      if (first.order > URGENT && this.hands.filter((one) => one.job).length >= this.count) return;
      if (hand.ready && !hand.job && (!hand.quick || first.order <= URGENT)) hand.take(this.queue.shift());
    }
  }
}
