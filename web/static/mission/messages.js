// What the robots of a mission have said; fetched when it is first opened.

import { id, list } from "../page/api.js";
import { replace } from "../page/dom.js";
import { createConversation } from "../speech/conversation.js";
import { sayingsOf } from "../speech/sayings.js";
import { ENDED } from "./timing.js";

const EVERY_MS = 2000;
const conversation = createConversation();
/** What was requested last, and when. */
let requested = { mission: "", at: 0 };

/** Request a mission's messages if it has changed, and now and then while it is under way. @param {Element} body @param {Mission} mission */
export async function showMessages(body, mission) {
  const known = JSON.stringify(mission);
  const isDrawn = conversation.node.parentElement === body;
  const isDue = !ENDED.includes(mission.state) && performance.now() - requested.at > EVERY_MS;
  if (document.hidden || (isDrawn && requested.mission === known && !isDue)) return;
  requested = { mission: known, at: performance.now() };
  const [said, robots] = await Promise.all([list(`/v1/missions/${id(mission.id)}/conversation`), list("/v1/robots")]);
  if (requested.mission !== known) return; // another mission is shown, or this one has changed
  if (conversation.node.parentElement !== body) replace(body, conversation.node);
  conversation.show(said.flatMap(sayingsOf), robots.filter((one) => one.world === mission.world).map((one) => one.name));
}
