// The way to a board by Web Serial: the browser asks which port, and the bytes go straight to it.

// Bits per second at which a board may be spoken to, the usual first (shared::link::RATES).
export const RATES = [2250000, 921600];

export function hasSerial() {
  return Boolean(navigator.serial);
}

export async function openSerial(port, baudRate) {
  await port.open({ baudRate, bufferSize: 1 << 16 });
  const writer = port.writable.getWriter();
  const reader = port.readable.getReader();
  let open = true;
  const transport = {
    onbytes: () => {},
    onclose: () => {},
    send: (bytes) => {
      writer.write(bytes.slice()).catch(() => ended("the port takes nothing any more; check the cable"));
    },
    close: async () => {
      open = false;
      await reader.cancel().catch(() => {});
      await writer.close().catch(() => {});
      await port.close().catch(() => {});
    },
  };
  function ended(why) {
    if (open) transport.onclose(why);
    open = false;
  }
  (async () => {
    try {
      for (;;) {
        const { value, done } = await reader.read();
        if (done) break;
        transport.onbytes(value);
      }
      ended("the port was closed");
    } catch (error) {
      ended(`the connection broke: ${error.message}; check the cable`);
    } finally {
      reader.releaseLock();
    }
  })();
  return transport;
}
