// Joins the page with its own frame of the view: what the page shows goes there, what is picked there comes back.

import { randomKey } from "../page/api.js";

const EVERY_MS = 100;

export function createLink({ onPick }) {
  const name = randomKey();
  let [shown, sent, socket, timer] = ["{}", null, null, null];

  function send() {
    timer = null;
    if (socket?.readyState !== WebSocket.OPEN || shown === sent) return;
    socket.send((sent = shown));
    timer = setTimeout(send, EVERY_MS);
  }

  // Answers once the connection is closed again: the service has gone.
  function open() {
    const address = new URL(`/v1/views/${name}`, location.href);
    address.protocol = address.protocol.replace("http", "ws");
    socket = new WebSocket(address);
    socket.onopen = () => {
      sent = null;
      send();
    };
    socket.onmessage = ({ data }) => onPick(JSON.parse(data));
    return new Promise((closed) => {
      socket.onclose = closed;
    });
  }

  return {
    name,
    open,
    show(what) {
      shown = JSON.stringify(what);
      timer ?? send();
    },
  };
}
