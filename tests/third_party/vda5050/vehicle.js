// Starts the virtual vehicle of the package vda-5050-lib, which speaks VDA 5050 2.0, as it is published.
//   node vehicle.js mqtt://HOST:PORT SERIAL X Y SPEED
// "end" on its standard input ends it in order.
const { AgvController, VirtualAgvAdapter } = require("vda-5050-lib");
const { createInterface } = require("node:readline");

const [brokerUrl, serialNumber, x, y, vehicleSpeed] = process.argv.slice(2);

const vehicle = new AgvController(
  { manufacturer: "VirtualWorks", serialNumber },
  { interfaceName: "uagv", transport: { brokerUrl, heartbeat: 2, reconnectPeriod: 500 }, vdaVersion: "2.0.0", topicObjectValidation: { inbound: true, outbound: false } },
  { agvAdapterType: VirtualAgvAdapter, publishVisualizationInterval: 200, publishStateInterval: 5000 },
  {
    initialPosition: { mapId: "default", x: Number(x), y: Number(y), theta: 0, lastNodeId: "0" },
    vehicleSpeed: Number(vehicleSpeed),
    tickRate: 20,
  },
);

const nodeActions = ["pick", "drop", "startCharging", "stopCharging"];
const instantActions = ["startPause", "stopPause", "startCharging", "stopCharging", "cancelOrder", "stateRequest", "factsheetRequest"];

function factsheet() {
  return {
    typeSpecification: { seriesName: "virtual", agvKinematic: "DIFF", agvClass: "CARRIER", maxLoadMass: 20, localizationTypes: ["NATURAL"], navigationTypes: ["AUTONOMOUS"] },
    physicalParameters: { speedMin: 0, speedMax: Number(vehicleSpeed), accelerationMax: 1, decelerationMax: 1, heightMax: 0.5, width: 0.4, length: 0.5 },
    protocolLimits: { maxStringLens: {}, maxArrayLens: {}, timing: { minOrderInterval: 0, minStateInterval: 0 } },
    protocolFeatures: {
      optionalParameters: [],
      agvActions: [...new Set([...nodeActions, ...instantActions])].map((actionType) => ({
        actionType,
        actionScopes: [...(nodeActions.includes(actionType) ? ["NODE"] : []), ...(instantActions.includes(actionType) ? ["INSTANT"] : [])],
      })),
    },
    agvGeometry: {},
    loadSpecification: {},
  };
}

vehicle.start().then(() => {
  vehicle.updateFactsheet(factsheet());
  console.log("ready");
});

createInterface({ input: process.stdin }).on("line", (line) => {
  if (line === "end") vehicle.stop().then(() => process.exit(0));
});
