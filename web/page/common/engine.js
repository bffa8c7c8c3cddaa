// The door to the module (web/src/door.rs): the name of a function and its argument as bytes, the answer as bytes.

const letters = new TextEncoder();
const text = new TextDecoder();

// The compiled module: it stands in the page, compressed and as letters.
export async function compileModule() {
  const coded = document.getElementById("module").textContent;
  const packed = Uint8Array.from(atob(coded), (letter) => letter.charCodeAt(0));
  const unpacked = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return WebAssembly.compile(await new Response(unpacked).arrayBuffer());
}

// An instance of the module. It has memory of its own and does one thing at a time: use it in a worker.
export class Engine {
  static async of(module) {
    const instance = await WebAssembly.instantiate(module, {});
    return new Engine(instance.exports);
  }

  constructor(door) {
    this.door = door;
  }

  // Calls a function with an argument: bytes, or a value that is written as JSON. The answer is bytes; an error has the
  // line that the module gave.
  call(name, argument) {
    const door = this.door;
    const first = letters.encode(name);
    const rest = argument instanceof Uint8Array ? argument : letters.encode(JSON.stringify(argument ?? null));
    const at = door.room(first.length + rest.length);
    const room = new Uint8Array(door.memory.buffer, at, first.length + rest.length);
    room.set(first);
    room.set(rest, first.length);
    let good;
    try {
      good = door.call(first.length);
    } catch (trap) {
      // The instance is of no use any more.
      const where = text.decode(new Uint8Array(door.memory.buffer, door.broke(), door.broke_bytes()));
      const error = new Error(`the computation broke off (${where || trap.message}); please report it`);
      error.fatal = true;
      throw error;
    }
    const answer = new Uint8Array(door.memory.buffer, door.answer(), door.answer_bytes()).slice();
    if (!good) throw new Error(text.decode(answer));
    return answer;
  }

  // The same, with the answer read as JSON.
  json(name, argument) {
    return JSON.parse(text.decode(this.call(name, argument)));
  }
}

// An answer read as JSON.
export function fromJson(bytes) {
  return JSON.parse(text.decode(bytes));
}
