// The service's public HTTP API. The session cookie authenticates.

const TIMEOUT_MS = 20_000; // a dead connection must not stop periodic requests
const RECONNECT_MS = 2000;

/** An error of the service, or that it cannot be reached (status 0). */
export class Problem extends Error {
  /** @param {{title?: string, detail?: string, status?: number, choices?: unknown[]}} body a problem+json body */
  constructor({ title = "", detail, status = 0, choices = [] }) {
    super(detail || title || "The service gave no reason");
    this.title = title;
    this.status = status;
    this.choices = choices;
  }

  withoutChoices() {
    return new Problem({ title: this.title, detail: this.message, status: this.status });
  }
}

/** @param {unknown} error @returns {Problem} what was thrown, to be shown */
export const problemOf = (error) => (error instanceof Problem ? error : new Problem({ detail: String(error) }));

export const id = encodeURIComponent;

/** @param {string} path @returns {Promise<any>} */
export async function get(path) {
  return parsed(await request(path, { headers: { accept: "application/json" }, signal: AbortSignal.timeout(TIMEOUT_MS) }));
}

/** @param {string} path @returns {Promise<any>} null if it does not exist (any longer) */
export async function getOrNull(path) {
  try {
    return await get(path);
  } catch (error) {
    if (error instanceof Problem && error.status === 404) return null;
    throw error;
  }
}

/** @param {string} path @returns {Promise<any[]>} the items of a list's first page: the newest */
export async function list(path) {
  return (await get(path)).items;
}

/** @param {string} path @param {object} body @returns {Promise<any>} */
export function post(path, body = {}) {
  return send("POST", path, body);
}

/** @param {string} path @param {object} body @param {Record<string, string>} headers @returns {Promise<any>} */
export function put(path, body, headers = {}) {
  return send("PUT", path, body, headers);
}

/** @param {string} method @param {string} path @param {object} body @param {Record<string, string>} more */
export async function send(method, path, body, more = {}) {
  const headers = { ...more, "content-type": "application/json", accept: "application/json", "idempotency-key": randomKey() };
  return parsed(await request(path, { method, headers, body: JSON.stringify(body) }));
}

/** @param {string} path @param {RequestInit} options */
async function request(path, options) {
  try {
    // Past the browser's cache, which lets a request wait while another for the same address is under way.
    return await fetch(path, { credentials: "same-origin", cache: "no-store", ...options });
  } catch {
    throw unreachable();
  }
}

const unreachable = () => new Problem({ title: "The service cannot be reached" });

/** @param {Response} response */
async function parsed(response) {
  const body = await response.json().catch((error) => {
    if (error instanceof SyntaxError) return null;
    throw unreachable();
  });
  if (response.ok) return body;
  throw new Problem({ status: response.status, title: response.statusText, ...(body ?? {}) });
}

export function randomKey() {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}

/**
 * Follow the service's events. The browser reconnects after a lost connection but gives up after an error response; then
 * a new stream is opened.
 * @param {string} path
 * @param {{onEvent: (event: ServiceEvent) => void, onState: (connected: boolean) => void}} listeners
 */
export function followEvents(path, { onEvent, onState }) {
  /** @type {EventSource} */
  let source;
  const open = () => {
    source = new EventSource(path);
    source.onopen = () => onState(true);
    source.onmessage = (message) => onEvent(parsedEvent(message.data));
    source.onerror = () => {
      onState(false);
      if (source.readyState === EventSource.CLOSED) setTimeout(open, RECONNECT_MS);
    };
  };
  open();
  // A page in the back-forward cache must not hold one of the few connections a browser grants to a host.
  addEventListener("pagehide", () => source.close());
  addEventListener("pageshow", (event) => event.persisted && open());
}

/** @param {string} data */
function parsedEvent(data) {
  try {
    return JSON.parse(data);
  } catch {
    return {};
  }
}
