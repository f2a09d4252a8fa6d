// The view of the bird's-eye scene of one task: it follows the ego or is moved freely. Knows nothing of the canvas.
import type { Pose } from "./motion.ts";
import { fitting, type Size, toWorld, type View, zoomed } from "./view.ts";

const START_SCALE = 7;

export class SceneCamera {
  /** The view follows the ego: it keeps the ego's place and points the ego's heading up. */
  following = $state(true);
  /** Size of the canvas, px. */
  size: Size = $state.raw({ width: 0, height: 0 });
  /** The free view; while following only its scale and anchor count. */
  #free: View = $state.raw({ x: 0, y: 0, scale: START_SCALE, turn: Math.PI / 2 });
  /** What was put in sight, ahead and left of the ego, m; null once the view was moved or zoomed by hand. */
  #shown: { ahead: number; left: number; maxScale: number } | null = null;
  #ego: () => Pose | null;

  /** `ego` is the pose of the ego now; null where the log has none. */
  constructor(ego: () => Pose | null) {
    this.#ego = ego;
  }

  /** The canvas has another size: what was put in sight stays in sight. */
  resize(size: Size): void {
    this.size = size;
    if (this.#shown && this.following && size.width > 0) this.#fit();
  }

  #fit(): void {
    if (!this.#shown) return;
    const { ahead, left, maxScale } = this.#shown;
    this.#free = { ...this.#free, ...fitting(this.size, ahead, left, maxScale) };
  }

  get view(): View {
    const ego = this.following ? this.#ego() : null;
    return ego ? { ...this.#free, x: ego.x, y: ego.y, turn: Math.PI / 2 - ego.heading } : this.#free;
  }

  /** Follows the ego, or leaves the view where it is. */
  setFollowing(following: boolean): void {
    if (!following) this.#free = this.view;
    this.following = following;
  }

  toggleFollowing(): void {
    this.setFollowing(!this.following);
  }

  /** Where the view is without an ego: over a world point, m. */
  centerOn(x: number, y: number): void {
    this.#free = { ...this.#free, x, y };
  }

  /** Zooms about a point of the canvas, px; about its middle without one. */
  zoom(factor: number, px = this.size.width / 2, py = this.size.height / 2): void {
    this.#shown = null;
    this.#free = zoomed(this.view, this.size, factor, px, py);
  }

  /**
   * Moves the world point that was at (`fromX`, `fromY`) px of the view `from` to (`toX`, `toY`) px. Ends following.
   */
  drag(from: View, fromX: number, fromY: number, toX: number, toY: number): void {
    const a = toWorld(from, this.size, fromX, fromY);
    const b = toWorld(from, this.size, toX, toY);
    this.following = false;
    this.#shown = null;
    this.#free = { ...from, x: from.x + a[0] - b[0], y: from.y + a[1] - b[1] };
  }

  /** Zooms out, or in up to `maxScale`, so that the ego and the target are both in sight; follows the ego. */
  showTarget(target: Pose, maxScale = START_SCALE): void {
    const ego = this.#ego();
    if (!ego) {
      this.centerOn(target.x, target.y);
      return;
    }
    const [dx, dy] = [target.x - ego.x, target.y - ego.y];
    const [cos, sin] = [Math.cos(ego.heading), Math.sin(ego.heading)];
    this.#shown = { ahead: dx * cos + dy * sin, left: dy * cos - dx * sin, maxScale };
    this.#fit();
    this.following = true;
  }
}
