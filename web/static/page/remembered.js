// What an operator has set up of the page, kept by the browser; the page works as well where it may keep nothing.

export function recall(name, otherwise) {
  try {
    return JSON.parse(localStorage.getItem(`macta.${name}`)) ?? otherwise;
  } catch {
    return otherwise;
  }
}

export function remember(name, value) {
  try {
    localStorage.setItem(`macta.${name}`, JSON.stringify(value));
  } catch {
    // private windows keep nothing
  }
}
