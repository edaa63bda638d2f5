/* What the console's modules hand to each other. */

type Child = Node | string | number | null | undefined | false | Child[];
type Listener<E extends Event> = (event: E) => unknown;

interface Attributes {
  onclick?: Listener<MouseEvent>;
  oninput?: Listener<Event>;
  onchange?: Listener<Event>;
  onkeydown?: Listener<KeyboardEvent>;
  onkeyup?: Listener<KeyboardEvent>;
  onpointerdown?: Listener<PointerEvent>;
  onpointermove?: Listener<PointerEvent>;
  onpointerleave?: Listener<PointerEvent>;
  onlostpointercapture?: Listener<PointerEvent>;
  onfocusout?: Listener<FocusEvent>;
  [name: string]: Listener<any> | string | number | boolean | null | undefined;
}

/** The page's state; `store.update` is the only way to change it. */
interface State {
  world: string | null;
  worlds: World[];
  worldTimes: Record<string, number>;
  goals: Goal[];
  missions: Mission[];
  /** Whether the service has older ones than are listed. */
  hasOlder: { goals: boolean; missions: boolean };
  robots: Robot[];
  /** Doors, hatches and lifts. */
  peripherals: Robot[];
  unknown: UnknownThing[];
  holds: Hold[];
  /** The robot, sample and plan action that are selected. */
  robot: string | null;
  sample: string | null;
  action: string | null;
  /** The view's camera follows the selected robot. */
  follow: boolean;
  /** Counts the requests to show the whole world. */
  whole: number;
  /** The mission whose recording is shown. */
  replaying: string | null;
  /** The id of the selected goal. */
  selected: string | null;
  /** The selected goal, which may be older than those listed; undefined before the first answer. */
  goal: Goal | null | undefined;
  /** The id of the plan chosen for viewing among alternatives. */
  viewedPlan: string | null;
  plan: Plan | null;
  /** The plan that `plan` replaces. */
  previousPlan: Plan | null;
  alternatives: Plan[];
  mission: Mission | null;
}

interface Store {
  get(): State;
  update(changes: Partial<State>): void;
  subscribe(listener: (state: State) => void): void;
}

interface TelemetryMessage {
  robots: Record<string, RobotTelemetry>;
}

interface Telemetry {
  setWorld(name: string | null): void;
  replay(robots: Record<string, RobotTelemetry> | null): void;
  follow(listener: (message: TelemetryMessage) => void): () => void;
}

interface Picked {
  kind: string;
  name: string;
}

/** A robot that works on a mission and is not heard. `since`: seconds, by the clock of who asks. */
interface Silence {
  robot: string;
  since: number;
  tone: string;
  word: string;
  note: string;
}

/** How an action differs from the previous plan. */
interface ActionChange {
  kind: "new" | "moved";
  words: string;
}

/** An action of the previous plan, on the new plan's time axis. */
interface PreviousAction {
  kind: "dropped" | "moved";
  words: string;
  agents: string[];
  tag: string;
  from: number;
  to: number;
  successor?: PlannedAction;
}

interface PlanChanges {
  byAction: Map<string, ActionChange>;
  previous: PreviousAction[];
  /** Draws the previous actions. */
  draw(scale: PictureScale): Child;
}

/** Positions in the plan's picture: lanes of robots in order, the time axis of `width` pixels up to `end` seconds. */
interface PictureScale {
  robots: string[];
  end: number;
  width: number;
  height: number;
  x(time_s: number): number;
  y(robot: string): number;
  actions: Map<string, PlannedAction>;
}

interface Picture {
  node: HTMLElement;
  show(plan: Plan, changes?: PlanChanges): void;
  showProgress(mission: Mission | null, time: number | null | undefined, silences?: Silence[]): void;
}

interface WorldDrawing {
  node: HTMLElement;
  showLayout(layout: WorldLayout): void;
  showSamples(places: Map<string, string>): void;
  showRobots(robots: Record<string, RobotTelemetry>, selected?: string | null): void;
  showPeripherals(reports: Robot[], now?: number, selected?: string | null): void;
  clearTrails(): void;
}

interface Recording {
  from: number;
  to: number;
  layout: WorldLayout;
  events: RecordedEvent[];
  results: RecordedResult[];
  robots(time: number): Record<string, RobotTelemetry>;
  samples(time: number): Map<string, string>;
  /** The robots of which minds were recorded. */
  minds: string[];
  mind(robot: string, time: number): Mind | null;
  mission(time: number): Mission | null;
  event(time: number): number;
}

/**
 * Something that was said. `heard_s`: null if nobody has reported to have heard it; `attempt`: how often it was said until it
 * was heard. Times: world's clock.
 */
interface Saying {
  from: string;
  to: string;
  performative: string;
  content: string;
  protocol: string;
  conversation: string;
  said_s: number;
  heard_s: number | null;
  attempt: number;
  isAnswered: boolean;
}

interface Conversation {
  node: HTMLElement;
  /** `robots`: the names that are robots'. */
  show(sayings: Saying[], robots: Iterable<string>): void;
}

/** A part of the workbench, from when it is opened until it is closed. */
interface WorkbenchPart {
  update(state: State): void;
  close(): void;
  onEvent?(event: ServiceEvent): void;
}

interface Workbench {
  open(part?: string): unknown;
  close(): unknown;
  onEvent(event: ServiceEvent): unknown;
}
