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

// Of answers that may overtake each other none is shown after one that was asked for later. Called when one is asked for;
// what it answers is called when that has come, and says whether it is to be shown.
export function inOrder() {
  let [asked, shown] = [0, 0];
  return () => {
    const turn = (asked += 1);
    return () => {
      if (turn < shown) return false;
      shown = turn;
      return true;
    };
  };
}

// Gathers calls that come close together into one that runs a little after the first, never two at once nor too soon after each other.
export function gathered(work, quietMs = 80, apartMs = 250) {
  let timer = null;
  let begun = -Infinity;
  let running = false;
  let again = false;
  const run = async () => {
    timer = null;
    if (running) {
      again = true;
      return;
    }
    running = true;
    begun = performance.now();
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
    timer ??= setTimeout(run, Math.max(quietMs, begun + apartMs - performance.now()));
  };
  return call;
}
