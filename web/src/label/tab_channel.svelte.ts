// Tabs of one browser that show the same task: each knows of the others and of what they saved.

type Message = { kind: "hello" | "present" | "bye" } | { kind: "saved"; version: number };

export class TabChannel {
  /** Another tab shows the task, too. */
  openElsewhere = $state(false);
  #channel: BroadcastChannel | null = null;

  /** Listens for the tabs of a task; `saved` is called with the version that another tab saved. */
  open(task: string, saved: (version: number) => void): void {
    this.#channel?.close();
    const channel = new BroadcastChannel(`whyroad.task.${task}`);
    channel.onmessage = ({ data }: MessageEvent<Message>) => {
      this.openElsewhere = data.kind !== "bye";
      if (data.kind === "hello") this.#send({ kind: "present" });
      if (data.kind === "saved") saved(data.version);
    };
    this.#channel = channel;
    this.openElsewhere = false;
    this.#send({ kind: "hello" });
  }

  announceSaved(version: number): void {
    this.#send({ kind: "saved", version });
  }

  /** Announces that this tab no longer shows the task. */
  leave(): void {
    this.#send({ kind: "bye" });
  }

  close(): void {
    this.leave();
    this.#channel?.close();
    this.#channel = null;
  }

  #send(message: Message): void {
    this.#channel?.postMessage(message);
  }
}
