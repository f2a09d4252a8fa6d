// The ruler of the bird's-eye view: two world points and the distance between them.

type Point = readonly [x: number, y: number];

export class Ruler {
  /** Presses on the scene measure instead of moving the view. */
  active = $state(false);
  /** World points, m; null before the first press. */
  from: Point | null = $state.raw(null);
  to: Point | null = $state.raw(null);

  /** Between the two points, m; null before there are two. */
  get distance(): number | null {
    return this.from && this.to ? Math.hypot(this.to[0] - this.from[0], this.to[1] - this.from[1]) : null;
  }

  start(): void {
    this.active = true;
    this.from = this.to = null;
  }

  stop(): void {
    this.active = false;
    this.from = this.to = null;
  }

  press(x: number, y: number): void {
    this.from = [x, y];
    this.to = null;
  }

  moveTo(x: number, y: number): void {
    if (this.from) this.to = [x, y];
  }
}
