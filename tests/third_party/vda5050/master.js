// The master control of the package vda-5050-lib, which speaks VDA 5050 2.0, as it is published, for one vehicle.
//   node master.js mqtt://HOST:PORT MANUFACTURER SERIAL
// A line of JSON on its standard input is an order ({"order": …}) or instant actions ({"instant": […]}), without headers;
// "end" ends it. What it is told of goes to its standard output, an event a line, and also what it drops as invalid.
const { MasterController, Topic } = require("vda-5050-lib");
const { createInterface } = require("node:readline");

const [brokerUrl, manufacturer, serialNumber] = process.argv.slice(2);
const vehicle = { manufacturer, serialNumber };

const say = (event) => console.log(JSON.stringify(event));
console.error = (...words) => say({ event: "dropped", why: words.map(String).join(" ") });

const master = new MasterController(
  { interfaceName: "uagv", transport: { brokerUrl, heartbeat: 2, reconnectPeriod: 500 }, vdaVersion: "2.0.0", topicObjectValidation: { inbound: true, outbound: true } },
  { targetAgvs: vehicle },
);

const ofOrders = {
  onOrderProcessed: (error, isCancelled, isActive, { order }) =>
    say({ event: "order", id: order.orderId, update: order.orderUpdateId, error: error?.errorType ?? null, isCancelled, isActive }),
  onNodeTraversed: (node) => say({ event: "node", id: node.nodeId }),
  onActionStateChanged: (state, error) => say({ event: "action", id: state.actionId, status: state.actionStatus, error: error?.errorDescription ?? null }),
};
const ofInstantActions = {
  onActionStateChanged: (state) => say({ event: "instant", id: state.actionId, status: state.actionStatus }),
  onActionError: (error, action) => say({ event: "instant", id: action.actionId, status: error.errorType }),
};

async function start() {
  await master.start();
  master.trackAgvs((_, state) => say({ event: "connection", state }));
  await master.subscribe(Topic.Factsheet, vehicle, (sheet) => say({ event: "factsheet", sheet }));
  await master.subscribe(Topic.State, vehicle, ({ paused, driving, loads, lastNodeId, orderId, errors }) =>
    say({ event: "state", paused, driving, loads: loads.map((load) => load.loadId), lastNodeId, orderId, errors: errors.map((one) => one.errorType) }));
  await master.subscribe(Topic.Visualization, vehicle, ({ agvPosition }) => say({ event: "pose", x: agvPosition.x, y: agvPosition.y }));
  say({ event: "ready" });
}

createInterface({ input: process.stdin }).on("line", (line) => {
  if (line === "end") return master.stop().then(() => process.exit(0));
  const { order, instant } = JSON.parse(line);
  const sent = order
    ? master.assignOrder(vehicle, order, ofOrders)
    : master.initiateInstantActions(vehicle, { instantActions: instant }, ofInstantActions);
  return sent.catch((error) => say({ event: "refused", why: error.message }));
});

start();
