// Short names for the server's types. schema.d.ts is generated from its OpenAPI document (`npm run types`).
import type { components } from "./schema.d.ts";

type Schemas = components["schemas"];

export type Session = Schemas["Session"];
export type User = Schemas["User"];
export type SignedOut = Schemas["SignedOut"];
export type ProviderAddress = Schemas["ProviderAddress"];
export type Returned = Schemas["Returned"];
export type Identity = Schemas["Identity"];
export type Project = Schemas["Project"];
export type Member = Schemas["Member"];
export type Role = Schemas["Role"];
export type Task = Schemas["Task"];
export type TaskSummary = Schemas["TaskSummary"];
export type Tasks = Schemas["Tasks"];
export type State = Schemas["State"];
export type Stage = Schemas["Stage"];
export type Finding = Schemas["Finding"];
export type Comment = Schemas["Comment"];
export type NewComment = Schemas["NewComment"];
export type FieldChange = Schemas["FieldChange"];
export type DraftSaved = Schemas["DraftSaved"];
export type DraftAt = Schemas["DraftAt"];
export type Lease = Schemas["Lease"];
export type ActionName = Schemas["ActionName"];
export type HistoryEntry = Schemas["HistoryEntry"];
export type Overlap = Schemas["Overlap"];
export type OverlapItem = Schemas["OverlapItem"];
export type Suggestion = Schemas["Suggestion"];
export type MatchedCondition = Schemas["MatchedCondition"];
export type Created = Schemas["Created"];
export type CreateTasks = Schemas["CreateTasks"];
export type MinedFolder = Schemas["MinedFolder"];
export type Dashboard = Schemas["Dashboard"];
export type SceneView = Schemas["SceneView"];
export type EgoView = Schemas["EgoView"];
export type TrackView = Schemas["TrackView"];
export type LightView = Schemas["LightView"];
export type CameraView = Schemas["CameraView"];
export type MapView = Schemas["MapView"];
export type LaneView = Schemas["LaneView"];
export type FrameworkView = Schemas["FrameworkView"];
export type NewProject = Schemas["NewProject"];
export type Kind = Schemas["Kind"];
export type QueueReason = Schemas["QueueReason"];

/** In `more` of a 409 `draft.conflict`, which the document does not describe (crates/whyroad-server/src/api/wire/task.rs). */
export interface Conflicts {
  version: number;
  draft: unknown;
  conflicts: FieldConflict[];
}

export interface FieldConflict {
  /** JSON pointer. */
  path: string;
  mine: unknown;
  theirs: unknown;
}
export type UserChange = Schemas["UserChange"];
export type Token = Schemas["Token"];
export type ProjectChange = Schemas["ProjectChange"];
export type Imported = Schemas["Imported"];
export type Webhook = Schemas["Webhook"];
export type Settings = Schemas["Settings"];
export type Coverage = Schemas["Coverage"];
export type Throughput = Schemas["Throughput"];
export type Agreement = Schemas["Agreement"];
