// What the service knows of the selected robot, requested and changed; an answer that comes once another robot is selected is dropped.

import { get, id } from "../page/api.js";
import { words } from "../page/format.js";
import { attempt } from "../page/problem.js";

/**
 * @template T
 * @param {string} what the last part of its path @param {Element} problem shows errors @param {(answer: T) => unknown} draw
 */
export function ofRobot(what, problem, draw) {
  /** @type {string | null} */
  let robot = null;
  const path = () => `/v1/robots/${id(robot ?? "")}/${what}`;

  /** Draw what a request answers. @param {() => Promise<any>} request @param {(HTMLButtonElement | HTMLInputElement)[]} [controls] disabled meanwhile */
  async function answer(request, controls = []) {
    const name = robot;
    if (name === null) return;
    await attempt(controls, problem, async () => {
      const answered = await request();
      if (robot === name) draw(answered);
    });
  }

  const load = () => answer(() => get(path()));
  return {
    path,
    answer,
    load,
    /** @param {string | null} name */
    select(name) {
      robot = name;
      return load();
    },
  };
}

/** How the robot has taken what it was sent. @param {{version: number, delivery: string, detail?: string | null}} sent @param {string} what */
export function deliveryText({ version, delivery, detail }, what = "") {
  return `version ${version}, ${what}${words(delivery)}${detail ? `: ${detail}` : ""}`;
}
