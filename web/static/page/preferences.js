// The operator's settings of the page, kept in the browser's local storage; without storage the defaults hold.

/** @param {string} name @param {unknown} fallback @returns {any} */
export function loadPreference(name, fallback) {
  try {
    return JSON.parse(localStorage.getItem(`macta.${name}`) ?? "null") ?? fallback;
  } catch {
    return fallback;
  }
}

/** @param {string} name @param {unknown} value */
export function savePreference(name, value) {
  try {
    localStorage.setItem(`macta.${name}`, JSON.stringify(value));
  } catch {
    // a private window may refuse to store
  }
}
