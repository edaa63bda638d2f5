/* The bodies of the service's HTTP API, as far as the console reads them. Times `*_at_s` are seconds of the world's clock. */

type Point = [x_m: number, y_m: number];

interface Fact {
  predicate: string;
  args: string[];
}

interface World {
  id: string;
  name: string;
  title?: string;
  time_s: number;
  version?: number;
  status?: "starting" | "waiting_for_fleet" | "running" | "failed";
  status_detail?: string;
  numbers_version?: number;
}

interface NumericFact {
  quantity: string;
  args: string[];
  value: number;
  text: string;
  source: string;
  at_s: number;
}

/** An area of the floor with its rule: named, keep_out, one_robot or slow. */
interface Zone extends Floor {
  rule: string;
  max_speed_m_s?: number | null;
}

interface Floor {
  name: string;
  x: Point;
  y: Point;
  aisles?: Floor[];
}

interface Wall {
  start: Point;
  end: Point;
  openings?: { kind: string; at_m: number; width_m: number }[];
}

interface Place {
  name: string;
  kind: string;
  at: Point;
}

/** A door or hatch with its panel, or a lift with its cabin and a panel a stop. */
interface Peripheral {
  name: string;
  kind: string;
  start?: Point | null;
  end?: Point | null;
  cabin?: { x: Point; y: Point } | null;
  stops?: { level: string; start: Point; end: Point }[];
}

interface WorldLayout {
  compartments: Floor[];
  walls?: Wall[];
  locations?: Place[];
  obstacles?: { at: Point; radius_m: number }[];
  slopes?: Floor[];
  zones?: Zone[];
  peripherals?: Peripheral[];
  robots: { name: string; body: { kind: string } }[];
  link?: unknown;
}

interface WorldEdit {
  edit: string;
  name?: string;
  at?: number[];
  sample?: { name: string; at: string };
  robot?: { name: string };
  place?: { name: string };
  zone?: Zone;
  speed_m_s?: number;
  repertoire?: string[];
  external?: boolean;
}

/** A robot of a world's layout, as far as it is edited. */
interface EditedRobot {
  name: string;
  speed_m_s: number;
  repertoire: string[];
  external?: boolean;
}

/** What a robot has told of itself, and what has become of it. */
interface Factsheet {
  robot: string;
  state: "in_force" | "postponed" | "announced" | "refused";
  reason: string;
  at_s: number;
  sheet: { repertoire: string[]; speed_m_s: number };
}

interface WorldEdition {
  edition: number;
  edits: WorldEdit[];
  actor: string;
  reason: string;
  undoes: number | null;
  undone_by: number | null;
  delivery: "pending" | "taken_up" | "refused";
  detail: string;
}

interface Hold {
  id: string;
  world: string;
  words: string;
  lost: { now: string; goal: string | null; reason: string }[];
  ends: string;
  text: string;
}

interface UnknownThing {
  name: string;
  reason: string;
  since_s?: number | null;
  last_believed?: (Fact & { source: string; at_s: number }) | null;
  earlier_believed?: (Fact & { source: string; at_s: number })[];
}

interface Goal {
  id: string;
  world: string;
  text: string;
  goal?: Fact[];
  state: string;
  reason?: string | null;
  outcome?: string | null;
  plan_id?: string | null;
  mission_id?: string | null;
  planning?: { engine: string; elapsed_s: number; makespan_s: number | null; lower_bound_s: number | null; waits_for: string } | null;
  alternatives?: { state: string; reason?: string; edited?: string | null } | null;
  deadline_s?: number | null;
  deadline_at_s?: number | null;
  not_before_at_s?: number | null;
  priority?: number;
  readings?: Reading[];
  constraints?: Constraints;
  conflict?: Conflict | null;
  joint_goal?: string | null;
  created_by: string;
  created_at: string;
}

/** Constraints that stand in the way of a plan together, in words. */
interface Conflict {
  constraints: string[];
  proven: boolean;
  complete: boolean;
}

/** Words of a sentence and what they were resolved to. */
interface Reading {
  said: string;
  means: string[];
}

interface Constraints {
  robots: string[];
  without: string[];
  avoid: string[];
  keep_empty: string[];
  keep?: Fact[];
  after: string[];
  preferences?: Preference[];
}

/** A constraint that a plan may break at a cost; one of its lists has names. */
interface Preference {
  robots: string[];
  without: string[];
  avoid: string[];
  keep_empty: string[];
  at_least: Record<string, number>;
  cost_s: number;
}

interface PreferenceOutcome {
  preference: string;
  cost_s: number;
  kept: boolean;
  reason?: string;
  longer_s?: number | null;
  longer_at_least_s?: number;
}

interface Terms {
  readings?: Reading[];
  constraints?: Constraints;
  holds?: { places: string[]; facts?: Fact[]; words?: string }[];
}

interface CheckedSentence extends Terms {
  goals: Fact[];
  preferences?: { preference: string; cost_s: number; conflict: string }[];
  issue: { detail: string } | null;
  completions: string[];
}

interface PlannedAction {
  id: string;
  tag: string;
  agents: string[];
  description?: string;
  duration_s: number;
  earliest_start_s: number;
  latest_start_s: number;
  slack_s: number;
  critical: boolean;
  preconditions?: Fact[];
  intended_effects?: Fact[];
  other_effects?: Fact[];
  deletes?: Fact[];
}

interface CausalLink {
  producer: string;
  consumer: string;
  fact: Fact;
}

/** By action of the previous plan (kept, reassigned) or of this one (shifted, seconds later), and by name. */
interface PlanDifference {
  kept?: Record<string, string>;
  reassigned?: Record<string, string>;
  shifted?: Record<string, number>;
  dropped?: string[];
  added?: string[];
  elapsed_s?: number;
  words: string[];
}

interface TenderBid {
  robot: string;
  state: string;
  offer: { cost_s: number; release_s: number; way_s: number; work_s: number; battery: number } | null;
  reason: string;
}

interface TenderLeg {
  id: string;
  goal: Fact;
  parts: { tags: string[]; bids: TenderBid[] }[];
  team: string[];
  why: string;
  is_planned: boolean | null;
}

interface Tender {
  reason: string;
  legs: TenderLeg[];
}

interface GoalForecast {
  goal: Fact;
  p10_s: number;
  p50_s: number;
  p90_s: number;
  deadline_s: number | null;
  on_time: number | null;
}

/** When goals are likely achieved; the quantiles belong to `probabilities`. */
interface PlanForecast {
  goals: GoalForecast[];
  on_time: number | null;
  lateness_quantiles_s: number[];
  probabilities: number[];
  made_at_s: number;
}

interface Plan {
  id: string;
  goal_id: string;
  state: string;
  actions: PlannedAction[];
  causal_links?: CausalLink[];
  robots: string[];
  objects?: Record<string, string>;
  makespan_s: number;
  lower_bound_s?: number | null;
  engine?: string;
  planning_s?: number;
  distance_m: number;
  energy_j: number;
  clearances: number;
  label?: string;
  comparison?: string;
  lanes: Record<string, [start_s: number, end_s: number, tag: string][]>;
  late?: { goal: Fact; late_s: number }[];
  value?: number | null;
  value_bound?: number | null;
  left_out?: { goal: Fact; value: number; reason: string }[];
  preferences?: { outcomes: PreferenceOutcome[]; cost_s: number; bound_s: number; cut_short: boolean } | null;
  forecast?: PlanForecast | null;
  on_time?: number | null;
  overtaken?: string[];
  repairs?: { plan_id: string; course: string; difference: PlanDifference } | null;
  recruitment?: Record<string, string>;
  tender?: Tender | null;
  comment?: string | null;
  reason?: string | null;
  decided_by?: string | null;
  decided_at?: string | null;
}

interface ActionExplanation {
  action: string;
  because: string[];
  robots: Record<string, string>;
  order: string[];
}

interface PlanExplanation {
  makespan: string[];
  waits: { words: string }[];
  constraints: { constraint: string; words: string }[];
  robots: Record<string, string>;
  actions: ActionExplanation[];
}

interface PacketProgress {
  tag: string;
  state: string;
  description?: string;
  detail?: string;
  delegated_to?: string | null;
  waits_for?: string[];
  started_at_s?: number | null;
  finished_at_s?: number | null;
  expected_start_s: number;
  expected_duration_s: number;
}

interface ScriptProgress {
  robot: string;
  state: string;
  delivery?: string;
  order?: string | null;
  lost?: boolean;
  packets?: PacketProgress[];
}

interface RecoveryAttempt {
  number: number;
  failure: string;
  reason: string;
  measure?: string | null;
  without?: string[];
  outcome: string;
  detail?: string | null;
}

interface Mission {
  id: string;
  goal_id: string;
  plan_id: string;
  world: string;
  state: string;
  reason?: string | null;
  failure?: string | null;
  cancel_requested?: boolean;
  estimate_s: number;
  original_estimate_s?: number | null;
  started_at_s: number;
  revised_at_s?: number | null;
  ended_at_s?: number | null;
  deadline_s?: number | null;
  enquire_at_s?: number | null;
  /** How many its packets have brought. */
  results?: number;
  progress?: ScriptProgress[];
  /** What planning it again would save, since a robot became available. */
  better_plan?: { made_at_s: number; ends_in_s: number; saves_s: number; robots: string[] } | null;
  /** Goals that waited and that it carries out beside its own. */
  joined_goals?: string[];
  recovery?: { policy: string; step: string | null; attempts: RecoveryAttempt[] };
  created_at: string;
}

/** What would come of planning a mission again; times from now. */
interface MissionPreview {
  reason: string;
  ends_in_s: number | null;
  expected_in_s: number | null;
  changes: string[];
  achieved: { goal: Fact; in_s: number }[];
  unkept: string;
}

/** What a packet has brought, `of` a place, sample or robot: the image of the camera `name`, or what was read of the quantity `name`. */
interface Result {
  id: string;
  mission_id: string;
  robot: string;
  packet_id: string;
  kind: "image" | "reading";
  name: string;
  of: string;
  at_s: number;
  created_at: string;
  value: number | null;
  unit: string;
}

/** A result of a recording, an image with its `data:` address. */
interface RecordedResult extends Result {
  image?: string;
}

/** A robot, or by its `kind` a door, hatch or lift, whose `state` is `opened`, `closed`, a lift's level or unknown. */
interface Robot {
  name: string;
  world: string;
  kind?: string;
  state?: string;
  connection: string;
  world_stands?: boolean;
  lost?: unknown;
  out_of_service?: { reason: string; taken_by: string } | null;
  silent?: boolean;
  last_heard_s?: number | null;
  heard_at_s?: number | null;
  next_contact_s: number;
  mission_id?: string | null;
  driven_by?: string | null;
  packet?: string | null;
  packet_state?: string | null;
  holding?: string | null;
  battery?: number | null;
  repertoire?: string[];
  reach?: string[];
  role?: string | null;
  /** What its mind is in; null of a door, hatch or lift. */
  body?: "virtual" | "simulated" | "real" | null;
}

/** A response in [-1, 1] and its utility in [0, 1]. */
type Utilitor = [response: number, utility: number];

interface RobotTelemetry {
  x_m: number;
  y_m: number;
  heading_rad: number;
  holding?: string | null;
  packet_tag?: string | null;
  packet_state?: string | null;
  patterns?: Record<string, Utilitor>;
  resultants?: Record<string, Utilitor>;
  ranges_m?: (number | null)[];
  tags?: Record<string, Point>;
  sensors?: string[];
  degraded?: string[];
  battery?: number;
  charging?: boolean;
  goal_m?: number | null;
  at_s: number;
}

/** Consecutive control ticks of one packet with the same active patterns. */
interface TraceStretch {
  patterns: { name: string; level: string }[];
  dofs: string[];
  ticks: { at_s: number; patterns: Utilitor[]; resultants: Utilitor[] }[];
}

interface Trace {
  at_s: number;
  stretches: TraceStretch[];
  conditions?: { when: string; words: string; holds: boolean | null }[];
}

/** By packet tag, pattern and parameter. */
type PatternParameters = Record<string, Record<string, Record<string, number>>>;

interface Tuning {
  version: number;
  delivery: string;
  detail?: string;
  tuning: PatternParameters;
  packets: PatternParameters;
}

/** A robot's rule files by the name of the agent or role, as they were sent last. */
interface RuledRobot {
  version: number;
  files: Record<string, string>;
  delivery: string;
  detail: string;
  comment: string;
  decided_by: string | null;
}

/** The role of a robot; `tags`: what it is recruited for, null: all that it can. */
interface RobotRole {
  version: number;
  role: string | null;
  tags: string[] | null;
  home: string | null;
  rules: string | null;
  delivery: string;
  detail: string;
  decided_by: string | null;
}

/** A sensor of a robot and the source of its readings: real or virtual. */
interface SourcedSensor {
  sensor: string;
  source: string;
}

/** The body that a robot's mind is in, and its moves, newest first. */
interface Embodiment {
  kind: "virtual" | "simulated" | "real";
  body: { kind: string };
  lease_until_s: number | null;
  attempts: { state: string; reason: string; body: { kind: string }; ended_at: string | null }[];
}

interface ToldBelief {
  term: string;
  value: boolean;
  origin: string;
  source: string;
  words: string;
  since_s: number;
}

/** One firing of a rule; `rule` is its file and line. */
interface ToldCommitment {
  rule: string;
  name: string;
  towards: string;
  bindings: Record<string, string>;
  made_s: number;
  state: string;
  reason: string | null;
  words: string;
}

interface ToldAgent {
  name: string;
  roles: string[];
  beliefs: ToldBelief[];
  belief_count: number;
  commitments: ToldCommitment[];
  commitment_count: number;
}

interface ToldConversation {
  protocol: string;
  partner: string;
  state: string;
  is_mine: boolean;
  reply_by_s: number | null;
}

interface Mind {
  at_s: number;
  agents: ToldAgent[];
  conversations: ToldConversation[];
}

interface BreakpointFiring {
  agent: string;
  rule: string;
  does: string;
  bindings: Record<string, string>;
}

interface BreakpointHalt {
  robot: string;
  at_s: number;
  firings: BreakpointFiring[];
  agents: ToldAgent[];
}

interface Breakpoints {
  robot: string;
  world: string;
  refusal: string;
  rules: string[];
  of_others: number;
  halts: BreakpointHalt[];
  left_s: number | null;
  ended: string;
}

interface DialogueLine {
  by: string;
  performative: string;
  content: string;
  words: string;
}

interface ShownPacket {
  tag: string;
  arguments: Record<string, string>;
  expected_duration_s: number;
}

interface Dialogue {
  id: string;
  robot: string;
  state: string;
  reason: string;
  text: string;
  question: { detail: string; choices: string[] } | null;
  script: ShownPacket[];
  lines: DialogueLine[];
}

interface TeleoperationState {
  driving: boolean;
  last_heard_s: number;
  most_m_s: number;
  most_rad_s: number;
}

/** What one robot has heard another say, and its answer. */
interface Speech {
  sender: string;
  robot: string;
  performative: string;
  content: string;
  protocol: string;
  conversation: string;
  sent_at_s: number;
  at_s: number;
  attempt?: number;
  /** Null if it is told on its own. */
  answer?: string | null;
  answer_content?: string;
  /** The person for whom the service says it. */
  speaker?: string;
}

/** A conversation of the service with a robot. */
interface ServiceConversation {
  id: string;
  protocol: string;
  speaker: string;
  said: { sender: string; receiver: string; performative: string; content: string; sent_at_s: number; at_s: number }[];
}

interface EventData {
  goal?: string;
  mission?: string;
  robot?: string;
  packet?: string;
  of?: string;
  actor?: string;
  source?: string;
  text?: string;
  reason?: string;
  detail?: string;
  events?: string[];
  ended?: string[];
  receiver?: string;
  world?: string;
  at_s?: number;
}

/** `time` is null in an event that reports the state of something, not a change. */
interface ServiceEvent {
  type?: string;
  subject?: string;
  time?: string | null;
  data?: EventData;
}

type RecordedPose = [at_s: number, x_m: number, y_m: number, heading_rad: number, holding: string | null, packet_tag: string | null];

interface RecordedEvent {
  at_s: number;
  type: string;
  subject?: string;
  data?: EventData;
}

interface Replay {
  world: { layout: WorldLayout };
  robots: Record<string, RecordedPose[]>;
  telemetry?: Record<string, { at_s: number }[]>;
  minds?: Record<string, Mind[]>;
  missions: { at_s: number; mission: Mission }[];
  samples: { at_s: number; lying: Record<string, string> }[];
  results?: RecordedResult[];
  events: RecordedEvent[];
  goal?: Goal | null;
  plans: Record<string, Plan>;
}
