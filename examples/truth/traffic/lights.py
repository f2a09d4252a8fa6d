"""traffic_light.*: from the lights' states, the link that the ego then took, its own speed, and who stood before it in its lane."""

from log import runs


def stands(rows, limit=0.3):
    return runs([k for k, o in rows.items() if o.speed < limit], gap=5)


def ahead_in_lane(run, ego, k):
    """Vehicles between the ego and the end of its lane."""
    me = run.rows[ego][k]
    return [i for i, o in run.by_time[k] if i != ego and not o.person and o.lane == me.lane and o.pos > me.pos and run.kind(i) != "bicycle"]


def riders_ahead(run, ego, k):
    """Whether a cyclist waits or rides between: whether that makes the ego second in the queue is not defined."""
    me = run.rows[ego][k]
    return any(i != ego and o.lane == me.lane and o.pos > me.pos and run.kind(i) == "bicycle" for i, o in run.by_time[k] if not o.person)


def starts_to_slow(rows, k):
    """The last moment before a stop at which the speed still did not fall for half a second."""
    while k - 1 in rows and any(rows[u].accel < -0.5 for u in range(k - 5, k) if u in rows):
        k -= 1
    return k


def lights(run, ego, all_passages):
    """- red_stop, yellow_stop: halts first in its lane within 10 m of the line while its link is y or r; keyframe the later of 0.5 s before
      it begins to slow (0.5 m/s2) and the light's turning y or r; the letter then decides which.
    - resume_first: so halted, the link turns green and it starts within 5 s; keyframe the later of 0.5 s before it starts and green.
    - resume_follow: halted behind others of its lane that stand at that link too; starts within 30 s of green.
    - green_pass: the light turns green while it rolls up within 80 m, after slowing by 2 m/s or more, nobody ahead in its lane; over the line
      at 5 m/s or more. Where it slowed less, or somebody is ahead: optional.
    """
    rows = run.rows[ego]
    for p in all_passages[ego]:
        if not p.link.tl:
            continue
        approach = [k for k in rows if k <= p.first and rows[k].lane.rsplit("_", 1)[0] == p.link.start]
        if not approach:
            continue
        length = run.road.lanes[p.link.lane].length
        halts = [(a, b) for a, b in stands(rows) if a in approach and b - a >= 3]
        for n, (a, b) in enumerate(halts):
            state, since = run.light(p.link, a)
            first = not ahead_in_lane(run, ego, a)
            at_line = length - rows[a].pos < 10
            changed_lane = rows[a].lane != p.link.lane or riders_ahead(run, ego, a)
            if first and state in "ryu" and a - 30 in rows:
                slow = starts_to_slow(rows, a)
                turned = halt_began(run, p.link, a)
                keyframe = max(slow - 5, turned)
                letter = run.light(p.link, keyframe)[0]
                # A stop out of creeping, or out of another stop, has no beginning of its own.
                again = n > 0 and slow - halts[n - 1][1] < 50 or rows[slow].speed < 3
                leaf = "yellow_stop" if letter == "y" else "red_stop"
                close = abs(slow - 5 - turned - 30) <= 4 or abs(keyframe - turned - 30) <= 2
                for each in ("red_stop", "yellow_stop") if close or changed_lane else (leaf,):
                    yield run.entry(f"reactive_rule.traffic_light.{each}", ego, keyframe - 20, keyframe, a + 10, optional=again or close or not 0.3 < length - rows[a].pos < 9.5 or changed_lane)
            # The release that ends this stand: green while it stood.
            green = next((k for k in range(a, b + 30) if run.light(p.link, k)[0] in "Gg" and (run.light(p.link, k - 1)[0] not in "Gg")), None)
            last_of_lane = n == len(halts) - 1
            if green is None or green > b + 2:
                continue
            start = next((k for k in range(b, b + 30) if k in rows and rows[k].accel > 0.5), b)
            keyframe = max(start - 5, green)
            ahead = [i for i in ahead_in_lane(run, ego, green) if run.rows[i][green].speed < 0.5]
            off = any(rows[k].speed > 2 for k in range(b, b + 80) if k in rows)
            if changed_lane:
                for leaf in ("resume_first", "resume_follow"):
                    yield run.entry(f"reactive_rule.traffic_light.{leaf}", ego, keyframe - 20, keyframe, keyframe + 30, optional=True)
            elif not ahead and at_line:
                yield run.entry("reactive_rule.traffic_light.resume_first", ego, keyframe - 20, keyframe, keyframe + 30,
                                optional=start - green > 35 or changed_lane or b - a < 15 or not off)
            elif ahead:
                yield run.entry("reactive_rule.traffic_light.resume_follow", ego, keyframe - 20, keyframe, keyframe + 30,
                                optional=start - green > 250 or changed_lane or b - a < 15 or not off or not last_of_lane and halts[n + 1][0] - b < 60)
        rolling = [k for k in approach if length - rows[k].pos < 80 and k > (halts[-1][1] if halts else 0)]
        if not rolling:
            continue
        soon = halts and rolling[-1] - halts[-1][1] < 100
        greens = [k for k in range(rolling[0] - 100, p.first) if k > 0 and run.light(p.link, k)[0] in "Gg" and run.light(p.link, k - 1)[0] not in "Gg"]
        if greens:
            keyframe = max(greens[-1], rolling[0])
            if keyframe in rows:
                slowed = max(rows[k].speed for k in range(keyframe - 50, keyframe + 1) if k in rows) - rows[keyframe].speed
                led = any(ahead_in_lane(run, ego, k) for k in range(keyframe, p.first, 5))
                sure = slowed > 2 and not led and rows[p.first].speed > 5.5 and greens[-1] >= rolling[0] and rows[keyframe].speed > 2.5
                yield run.entry("reactive_rule.traffic_light.green_pass", ego, keyframe - 20, keyframe, p.first, optional=not sure or soon or riders_ahead(run, ego, keyframe))


def unfinished(run, ego, all_passages):
    """Halts after the last junction that the log still sees: which link the ego wants is not known."""
    rows = run.rows[ego]
    last = max([p.last for p in all_passages[ego]], default=0)
    for a, b in stands(rows):
        if a > last and not rows[a].lane.startswith(":"):
            slow = starts_to_slow(rows, a)
            for leaf in ("red_stop", "yellow_stop"):
                yield run.entry(f"reactive_rule.traffic_light.{leaf}", ego, slow - 25, slow - 5, a + 10, optional=True)
            for leaf in ("resume_first", "resume_follow"):
                yield run.entry(f"reactive_rule.traffic_light.{leaf}", ego, b - 25, b - 5, b + 30, optional=True)


def halt_began(run, link, k):
    """When the link last turned from green to anything else, before `k`."""
    while k > 0 and run.light(link, k - 1)[0] not in "Gg":
        k -= 1
    return k
