// The frame with the view in three dimensions: viser's page, served by a process of its own. This module contains all that
// we rely on in viser's page: `?darkMode`, the id of its notice, that it checks `hasFocus()` before it reconnects, its width.

import { get, randomKey } from "../page/api.js";
import { byId } from "../page/dom.js";
import { isDark, onTheme } from "../page/theme.js";

const RETRY_MS = 1500;
const SEND_EVERY_MS = 100;
const MIN_WIDTH_PX = 600; // on a narrower page viser shows its layout for telephones
const SOFTWARE_NOTICE = "webgl-software-rendering";

/** @param {(picked: Picked) => void} onPick */
export function createViewFrame(onPick) {
  const frame = byId("stage", HTMLIFrameElement);
  const link = createViewLink(onPick);
  let isOpened = false;
  return {
    show: link.show,
    get isVisible() {
      return !frame.hidden;
    },
    /** Open the view and keep it open. Called late, for viser's page is much larger than the console. */
    open() {
      if (!isOpened) keepOpen(frame, link);
      isOpened = true;
    },
    /** @param {number} width of the frame's holder, pixels */
    fit(width) {
      const scale = Math.min(1, width / MIN_WIDTH_PX) || 1;
      const size = `${100 / scale}%`;
      Object.assign(frame.style, { width: size, height: size, transform: scale < 1 ? `scale(${scale})` : "" });
    },
  };
}

/**
 * The first request starts the view, which ends when no page shows it. While it is not running no socket is opened:
 * after repeated failures browsers delay new sockets for longer than viser waits.
 * @param {HTMLIFrameElement} frame @param {ReturnType<typeof createViewLink>} link
 */
async function keepOpen(frame, link) {
  const note = byId("stage-note", HTMLElement);
  const address = () => `/viewer/${link.name}/${isDark() ? "?darkMode" : ""}`;
  frame.addEventListener("load", () => {
    if (frame.contentDocument?.contentType === "text/html") adaptPage(frame);
    else link.close(); // the view ended between the question whether it runs and the request of its page
  });
  document.addEventListener("visibilitychange", () => frame.contentWindow?.dispatchEvent(new Event("focus")));
  onTheme(() => {
    if (!frame.hidden && frame.getAttribute("src") !== address()) frame.src = address();
  });
  for (;;) {
    while (!(await isRunning())) await pause();
    const closed = link.open();
    frame.src = address();
    frame.hidden = false;
    note.hidden = true;
    await closed;
    frame.src = "about:blank";
    frame.hidden = true;
    note.hidden = false;
    await pause();
  }
}

const pause = () => new Promise((resolve) => setTimeout(resolve, RETRY_MS));

async function isRunning() {
  return (await get("/v1/view").catch(() => null))?.running === true;
}

/** @param {HTMLIFrameElement} frame */
function adaptPage(frame) {
  const page = frame.contentDocument;
  if (!page) return;
  // viser's page reconnects only while it has the focus; in the frame it must do so whenever the console is visible.
  page.hasFocus = () => !document.hidden;
  frame.contentWindow?.dispatchEvent(new Event("focus"));
  // Its notice of software rendering would cover the world until it is closed: the console shows it beside the world.
  const style = page.createElement("style");
  style.textContent = `#${SOFTWARE_NOTICE} { display: none; }`;
  page.head.append(style);
  const note = byId("software-note", HTMLElement);
  note.hidden = true;
  const observer = new MutationObserver(() => {
    if (!page.getElementById(SOFTWARE_NOTICE)) return;
    note.hidden = false;
    observer.disconnect();
  });
  observer.observe(page.body, { childList: true, subtree: true });
}

/**
 * Joins the page with its frame through the service: what the page shows is sent there, what is picked there comes back.
 * @param {(picked: Picked) => void} onPick
 */
function createViewLink(onPick) {
  const name = randomKey();
  let shown = "{}";
  /** @type {string | null} */
  let sent = null;
  /** @type {WebSocket | null} */
  let socket = null;
  /** @type {number | undefined} */
  let timer;

  function send() {
    timer = undefined;
    if (socket?.readyState !== WebSocket.OPEN || shown === sent) return;
    sent = shown;
    socket.send(shown);
    timer = setTimeout(send, SEND_EVERY_MS);
  }

  return {
    name,
    /** Resolves when the connection is closed again: the service has ended. */
    open() {
      const address = new URL(`/v1/views/${name}`, location.href);
      address.protocol = address.protocol.replace("http", "ws");
      const opened = new WebSocket(address);
      socket = opened;
      opened.onopen = () => {
        sent = null;
        send();
      };
      opened.onmessage = ({ data }) => onPick(JSON.parse(data));
      return new Promise((resolve) => {
        opened.onclose = resolve;
      });
    },
    close: () => socket?.close(),
    /** @param {object} state */
    show(state) {
      shown = JSON.stringify(state);
      if (timer === undefined) send();
    },
  };
}
