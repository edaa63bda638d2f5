// Taking the selected robot out of service, with a reason, and bringing it back.

import { id, post } from "../page/api.js";
import { badge, el } from "../page/dom.js";
import { attempt, commandButton } from "../page/problem.js";

/** @param {Robot} robot @param {Element} box shows an error @param {() => void} done */
export function serviceControl(robot, box, done) {
  const path = `/v1/robots/${id(robot.name)}`;
  if (robot.out_of_service) {
    const { reason, taken_by: by } = robot.out_of_service;
    const back = commandButton("Bring back", `${path}:bring_back`, box, done, { "data-testid": "robot-bring_back" });
    return el("div", { class: "row service" }, badge("warn", "out of service"), el("span", { class: "grow" }, `${reason} (${by})`), back);
  }
  const reason = el("input", { required: true, maxlength: 2000, placeholder: "Reason", "aria-label": "Reason for taking it out of service", "data-testid": "robot-service-reason" });
  const take = el("button", { type: "submit", "data-testid": "robot-take_out_of_service" }, "Take out");
  /** @param {Event} event */
  const send = async (event) => {
    event.preventDefault();
    await attempt([take], box, () => post(`${path}:take_out_of_service`, { reason: reason.value }));
    done();
  };
  return el("details", { class: "service" }, el("summary", { class: "quiet" }, "Take out of service"), el("form", { class: "row", onsubmit: send }, reason, take));
}
