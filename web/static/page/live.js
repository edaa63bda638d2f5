// Follows the service's events. The browser reconnects by itself after a lost connection, but gives up when the
// service answers with an error, so we open the stream anew then.

const AGAIN_MS = 2000;

export function follow(path, { onEvent, onState }) {
  let source = null;
  const open = () => {
    source = new EventSource(path);
    source.onopen = () => onState(true);
    source.onmessage = (message) => onEvent(parsed(message.data));
    source.onerror = () => {
      onState(false);
      if (source.readyState === EventSource.CLOSED) setTimeout(open, AGAIN_MS);
    };
  };
  open();
  // A page that is left must not hold one of the few connections a browser grants to a host.
  addEventListener("pagehide", () => source.close());
  addEventListener("pageshow", (event) => event.persisted && open());
}

function parsed(data) {
  try {
    return JSON.parse(data);
  } catch {
    return {};
  }
}
