// The way to a board through `host-sim link PORT --page`: the page's own server, by WebSocket. Bytes are the board's protocol;
// words say who commands, whether the board is heard, and what was lost on the way here.

// Which board the server has; null without one, or if the page comes from a file or another site.
export async function boardOfServer() {
  if (!location.protocol.startsWith("http")) return null;
  try {
    const answer = await fetch("board", { cache: "no-store" });
    return answer.ok ? (await answer.json()).board : null;
  } catch {
    return null;
  }
}

export function openServer() {
  const address = new URL("wire", location.href.split("#")[0]);
  address.protocol = "ws:";
  const socket = new WebSocket(address);
  socket.binaryType = "arraybuffer";
  const transport = {
    onbytes: () => {},
    onwords: () => {},
    onclose: () => {},
    send: (bytes) => socket.readyState === WebSocket.OPEN && socket.send(bytes),
    say: (act) => socket.readyState === WebSocket.OPEN && socket.send(JSON.stringify({ act })),
    close: () => socket.close(),
  };
  socket.onmessage = ({ data }) => {
    if (typeof data === "string") transport.onwords(JSON.parse(data));
    else transport.onbytes(new Uint8Array(data));
  };
  socket.onclose = () => transport.onclose("the connection to the server has ended; is host-sim still running? Then reload the page");
  return new Promise((resolve, reject) => {
    socket.onopen = () => resolve(transport);
    socket.onerror = () => reject(new Error("the server does not let this page in; open the whole address that host-sim has printed"));
  });
}
