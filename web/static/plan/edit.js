// A change to a plan: what is to be otherwise about an action. A proposed plan is planned once more beside the old one; of a
// plan that is carried out, what is left is planned again.

import { get, id, post } from "../page/api.js";
import { el, show } from "../page/dom.js";
import { byNumber, facts, seconds } from "../page/format.js";
import { attempt, problemBox } from "../page/problem.js";

/** @type {Record<string, {text: string, label: string, names: "robots" | "places" | "interchanges" | "actions" | null}>} */
const CHANGES = {
  robot: { text: "is done by", label: "Robot", names: "robots" },
  without: { text: "is done without", label: "Robot", names: "robots" },
  avoid: { text: "avoids", label: "Place", names: "places" },
  via: { text: "goes through", label: "Interchange", names: "interchanges" },
  after: { text: "comes after", label: "What another action is done for", names: "actions" },
  not_before_s: { text: "comes true no earlier than", label: "Seconds from now", names: null },
};

/** What would come of planning a mission again. @param {string} what @param {MissionPreview} preview */
function described(what, { reason, ends_in_s: ends, expected_in_s: expected, changes, achieved, unkept }) {
  if (ends === null) return el("p", { class: "small" }, el("b", {}, what), `: no plan; ${reason}`);
  const times = achieved.length > 1 ? `; ${achieved.map((one) => `${facts([one.goal])} after ${seconds(one.in_s)}`).join(", ")}` : "";
  const present = expected === null ? "" : ` (by the present plan in ${seconds(expected)})`;
  return el("p", { class: "small" }, el("b", {}, what), `: ends in ${seconds(ends)}${present}${times}`, changes.length ? `; ${changes[0]}` : "", unkept ? `; does not keep to: ${unkept}` : "");
}

/** @param {Plan} plan @param {State} state @param {() => void} refresh */
export async function editForm(plan, state, refresh) {
  const robots = state.robots.filter((one) => one.world === state.goal?.world).map((one) => one.name);
  /** @type {{ layout: WorldLayout }} */
  const { layout } = await get(`/v1/worlds/${id(state.goal?.world ?? "")}`);
  const interchanges = (layout.locations ?? []).filter((one) => one.kind === "interchange").map((one) => one.name);
  const names = { robots, interchanges, places: Object.keys(plan.objects ?? {}).filter((name) => !robots.includes(name)) };
  const actions = [...plan.actions].sort((one, other) => byNumber(one.id, other.id));
  const options = () => actions.map((one) => el("option", { value: one.id, selected: one.id === state.action }, `${one.id} ${one.tag}: ${one.description ?? one.agents.join(" and ")}`));
  const action = el("select", { "aria-label": "Action", "data-testid": "edit-action", onchange: () => CHANGES[change.value].names === "actions" && draw() }, options());
  const change = el("select", { "aria-label": "Change", "data-testid": "edit-change", onchange: draw }, Object.entries(CHANGES).map(([value, { text }]) => el("option", { value }, text)));
  const value = el("span");
  const box = el("div", { role: "alert" });
  let isChanged = false; // what is chosen at first is not meant
  const mission = plan.state === "approved" ? state.mission : null;
  const path = mission ? `/v1/missions/${id(mission.id)}:replan` : `/v1/plans/${id(plan.id)}:edit`;
  const hint = mission
    ? "What is not done yet is planned again, with the robots of now. The mission's robots stand still meanwhile."
    : "The plan is made once more with as few changes as pays. It can be approved instead of this one, which stays.";
  const button = el("button", { type: "submit", "data-testid": "edit-plan" }, "Plan with this change");
  const again = mission && el("button", { type: "button", "data-testid": "replan", onclick: () => ask([]) }, "Plan without a change");
  const look = mission && el("button", { type: "button", "data-testid": "preview", title: "What would come of it; the robots go on meanwhile", onclick: preview }, "Preview");
  const outcome = el("div", { class: "note", role: "status", "data-testid": "preview-outcome", hidden: true });
  const waiting = state.goals.filter((goal) => mission && goal.world === mission.world && goal.state === "waiting" && !goal.joint_goal);
  const boxes = waiting.map((goal) => el("input", { type: "checkbox", value: goal.id, "data-testid": "join-goal" }));
  const joined = waiting.length > 0 && el("fieldset", {}, el("legend", { class: "small" }, "also carry out, of the goals that wait"), waiting.map((goal, n) => el("label", { class: "small" }, boxes[n], ` ${goal.text}`)));
  const form = el(
    "form",
    { class: "edit", onsubmit: send, oninput: (/** @type {Event} */ event) => (isChanged ||= !boxes.some((one) => one === event.target)) },
    el("p", { class: "quiet small" }, hint),
    action,
    el("div", { class: "row" }, el("label", { class: "small" }, "what it is done for "), change, value),
    joined,
    el("div", { class: "row" }, button, again, look),
    outcome,
    box,
  );

  function draw() {
    const { label, names: kind } = CHANGES[change.value];
    const shared = { "aria-label": label, name: "value", "data-testid": "edit-value", required: true };
    if (!kind) show(value, el("input", { ...shared, type: "number", min: 0, max: 1e7, value: 60 }));
    else if (kind === "actions") show(value, el("select", shared, options().filter((one) => one.value !== action.value)));
    else show(value, el("select", shared, names[kind].sort(byNumber).map((name) => el("option", {}, name))));
  }

  /** The change that is chosen. */
  function chosen() {
    const given = String(new FormData(form).get("value") ?? "");
    return [{ action: action.value, [change.value]: CHANGES[change.value].names ? given : Number(given) }];
  }

  /** @param {Event} event */
  function send(event) {
    event.preventDefault();
    ask(chosen());
  }

  /** @param {Record<string, string | number>[]} edits */
  function asked(edits) {
    const goals = boxes.filter((one) => one.checked).map((one) => one.value);
    return goals.length ? { edits, goals } : { edits };
  }

  async function preview() {
    outcome.hidden = true;
    await attempt(look ? [look] : [], box, async () => {
      const at = `/v1/missions/${id(mission?.id ?? "")}:preview`;
      const plain = described("Without a change", await post(at, asked([])));
      const changed = isChanged && await post(at, asked(chosen())).then((found) => described("With this change", found), problemBox);
      show(outcome, [plain, changed]);
      outcome.hidden = false;
      if (look) look.disabled = false;
    });
  }

  /** @param {Record<string, string | number>[]} edits */
  async function ask(edits) {
    const buttons = again ? [button, again] : [button];
    await attempt(buttons, box, async () => {
      await post(path, asked(edits));
      for (const one of buttons) one.disabled = false;
    });
    refresh();
  }

  draw();
  return form;
}
