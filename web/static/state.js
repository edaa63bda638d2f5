// What the page knows. Every change goes through `update`, after which the parts draw themselves anew.

export function createState(initial) {
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

// Gathers calls that come close together into one that runs when the last has been quiet, never two at once.
export function gathered(work, quietMs = 80) {
  let timer = null;
  let running = false;
  let again = false;
  const run = async () => {
    timer = null;
    if (running) {
      again = true;
      return;
    }
    running = true;
    try {
      await work();
    } finally {
      running = false;
      if (again) {
        again = false;
        call();
      }
    }
  };
  // Not put off by later calls: a steady stream of events must not starve the page.
  const call = () => {
    timer ??= setTimeout(run, quietMs);
  };
  return call;
}
