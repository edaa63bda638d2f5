// The page's state, and the order and rate of its changes.

/** @param {State} initial @returns {Store} */
export function createStore(initial) {
  /** @type {((state: State) => void)[]} */
  const listeners = [];
  const state = { ...initial };
  return {
    get: () => state,
    update(changes) {
      Object.assign(state, changes);
      for (const listener of listeners) listener(state);
    },
    subscribe(listener) {
      listeners.push(listener);
    },
  };
}

/**
 * Orders responses that may overtake each other. Call it when a request is sent; the function it returns, called when the
 * response has come, is true unless the response to a later request was shown already.
 */
export function responseOrder() {
  let sent = 0;
  let shown = 0;
  return () => {
    const number = (sent += 1);
    return () => {
      if (number < shown) return false;
      shown = number;
      return true;
    };
  };
}

/**
 * Merge calls that come close together into one run of `work`, never two at once nor sooner than `apartMs` after each other.
 * @param {() => unknown} work
 */
export function throttled(work, quietMs = 80, apartMs = 250) {
  /** @type {number | undefined} */
  let timer;
  let startedAt = -Infinity;
  let isRunning = false;
  let isDue = false;
  const run = async () => {
    timer = undefined;
    if (isRunning) {
      isDue = true;
      return;
    }
    isRunning = true;
    startedAt = performance.now();
    try {
      await work();
    } finally {
      isRunning = false;
      if (isDue) {
        isDue = false;
        call();
      }
    }
  };
  // Later calls do not postpone it: otherwise a steady stream of events would prevent any update.
  const call = () => {
    timer ??= setTimeout(run, Math.max(quietMs, startedAt + apartMs - performance.now()));
  };
  return call;
}
