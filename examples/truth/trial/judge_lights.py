"""traffic_light.*: the link that the ego took, the letters it showed, the ego's own speed, and who stood before it
in its lane.
"""

from judge_traffic import stood

T = "reactive_rule.traffic_light."


def before_it(w, ego, k, bicycles=False):
    me = w.rows[ego][k]
    return [i for i in w.at[k] if i != ego and w.rows[i][k].lane == me.lane and w.rows[i][k].pos > me.pos and not w.rows[i][k].person and (bicycles or w.kind(i) != "bicycle")]


def first_pulse(rows, slow):
    """Some drivers' models slow in pulses, others drive in pulses all the time: the slowing begins with the first one
    after which the speed of before is not regained.
    """
    begin, pulses = slow, []
    while begin - 1 in rows and any(rows[u].a < -0.5 for u in range(begin - 20, begin) if u in rows):
        begin -= 1
        if rows[begin].a < -0.5:
            pulses.append(begin)
    for k in reversed(pulses):
        if rows[k].v > 0.1 + max((rows[u].v for u in range(k + 5, slow + 20) if u in rows), default=0):
            return k
    return slow


def lights(w, ego):
    rows = w.rows[ego]
    previous, last_lit = min(rows), False
    for p in w.passing[ego]:
        if not p.whole:
            continue
        begin, lit = previous, last_lit
        if p.node.real or p.link.tl:
            previous, last_lit = p.last, bool(p.link.tl)
        if not p.link.tl:
            continue
        # Where the road only widens it is the same approach.
        approach = [k for k in range(begin, p.first) if k in rows and (k > begin or not rows[k].lane.startswith(":"))]
        way = w.way(ego)
        left = lambda k: w.net.lanes[rows[k].lane].length - rows[k].pos if rows[k].lane == p.link.lane else way[p.first] - way[k]
        on_last = [k for k in approach if rows[k].lane.rsplit("_", 1)[0] == p.link.a]
        halts = [(a, b) for a, b in stood(rows, 3) if a in approach]
        for n, (a, b) in enumerate(halts):
            moved_over = rows[a].lane != p.link.lane
            far = a not in on_last or left(a) > 9.5
            letter = w.letter(p.link, a)
            mixed = moved_over or len(before_it(w, ego, a)) != len(before_it(w, ego, a, True))
            if not before_it(w, ego, a) and letter in ("r", "y", "u") and (not far or a in on_last and left(a) < 15):
                # The last meters are often rolled out softly: the slowing that ends here began before them.
                slow = next((k for k in range(a, a - 40, -1) if k in rows and rows[k].a < -0.5), a)
                slow = first_pulse(rows, slow)
                turned = w.turned_to(p.link, a, "ryu")
                key = max(slow - 5, turned)
                yellow = w.letter(p.link, max(slow, turned)) == "y"
                # Yellow lasts 3 s, or longer.
                red = w.turned_to(p.link, a, "r")
                edge = turned and (abs((slow - turned) - 30) < 8 if red - turned < 45 else abs(slow - red) < 8)
                # Who had slowed by 2 m/s for something else when the light changed: whether it starts to slow then is open.
                edge |= slow < turned - 5 and max(rows[k].v for k in range(turned - 30, turned + 1) if k in rows) - rows[min(turned, a)].v > 2
                # Who stood ahead when it began to slow, and does not where it comes to stand, may have been what it slowed for.
                its = w.rows.get(rows[slow].leader, {}).get(slow)
                edge |= its is not None and its.v < 1.5 and rows[slow].gap < 60
                if lit and slow < begin:
                    # It slowed at the light before already: since when for this one, too, is open.
                    edge = True
                    for leaf in ("red_stop", "yellow_stop"):
                        yield w.entry(T + leaf, ego, begin - 20, max(begin, turned), a + 10, optional=True)
                again = n and slow - halts[n - 1][1] < 60 or max(rows[u].v for u in range(slow - 20, slow + 1) if u in rows) < 4
                for leaf in ("red_stop", "yellow_stop"):
                    sure = leaf == ("yellow_stop" if yellow else "red_stop") and not (again or edge or mixed or far)
                    if sure or again or edge or mixed or far:
                        yield w.entry(T + leaf, ego, key - 20, key, a + 10, optional=not sure)
            if letter == "s" and left(a) < 15:
                # Red for all but who turns right, who has to stop: whether that is a stop at a red light, and the start
                # after it one at a light, is open.
                for leaf in ("red_stop", "yellow_stop", "resume_first", "resume_follow"):
                    for key in (a - 30, a - 10, b - 5):
                        yield w.entry(T + leaf, ego, key - 20, key, max(key, a) + 30, optional=True)
            green = next((k for k in range(a, b + 30) if w.letter(p.link, k) in ("G", "g") and w.letter(p.link, k - 1) not in ("G", "g")), None)
            if green is None:
                # Green already when it comes to stand: by little, and what releases it is open.
                before = next((k for k in range(a - 1, a - 40, -1) if w.letter(p.link, k) not in ("G", "g")), None)
                if before is not None and before_it(w, ego, a):
                    yield w.entry(T + "resume_follow", ego, b - 25, b - 5, b + 25, optional=True)
                continue
            # The class asks for a line within 80 m, this leaf only for a queue at the light.
            distant = left(a) > 75
            start = next((k for k in range(min(b, b), b + 30) if k in rows and rows[k].a > 0.5), b)
            key = max(start - 5, green)
            off = any(rows[k].v > 3 for k in range(b, b + 70) if k in rows)
            now = rows[min(green, max(rows))]
            ahead = before_it(w, ego, min(green, max(rows))) or a not in on_last and now.leader and now.gap < 15
            again = any(start < h[0] < start + 100 for h in halts[n + 1:])
            if not ahead:
                yield w.entry(T + "resume_first", ego, key - 20, key, key + 30, optional=mixed or left(a) > 9.5 or start - green > 40 or b - a < 15 or not off or again)
                if mixed:
                    # Whether a rider ahead counts as the first is open.
                    yield w.entry(T + "resume_follow", ego, key - 20, key, key + 30, optional=True)
            else:
                yield w.entry(T + "resume_follow", ego, key - 20, key, key + 30, optional=mixed or distant or start - green > 200 or b - a < 15 or not off or again or start < green + 3)
        rolling = [k for k in on_last if left(k) < 80 and k > (halts[-1][1] + 60 if halts else 0)]
        if not rolling:
            continue
        # Green as it comes: it counts where it slowed before and the light turned green; a steady green with no
        # adjustment is none.
        v = [rows[k].v for k in rolling]
        turned = next((k for k in range(rolling[0] - 50, p.first) if k > 0 and w.letter(p.link, k) in ("G", "g") and w.letter(p.link, k - 1) not in ("G", "g")), None)
        dip = max(v) - min(v) > 1.0
        if rows[p.first].v < 4.5:
            continue
        # It turns green while the ego is further off: from where on one approaches is not said.
        early = next((k for k in range(rolling[0], rolling[0] - 120, -1) if k in rows and k - 1 in rows and way[p.first] - way[k] < 220 and w.letter(p.link, k) in ("G", "g") and w.letter(p.link, k - 1) not in ("G", "g")), None)
        if early is not None:
            yield w.entry(T + "green_pass", ego, early - 20, early, max(early + 30, p.first), optional=True)
            yield w.entry(T + "green_pass", ego, early - 20, early, early + 30, optional=True)
        if turned is None and not dip:
            continue
        led = any(before_it(w, ego, k) for k in range(rolling[0], p.first, 5) if k in rows)
        key = max(turned or rolling[0], rolling[0])
        slowed = max(rows[k].v for k in range(key - 60, key + 1) if k in rows) - rows[key].v
        sure = turned is not None and turned >= rolling[0] and slowed > 2.2 and not led and rows[p.first].v > 5.5 and rows[key].v > 2.5
        yield w.entry(T + "green_pass", ego, key - 20, key, p.first, optional=not sure)
    # Halts at a light after the last whole passage: the link that it wants is not known.
    for a, b in stood(rows, 0):
        if a > previous or not any(p.first > a and p.whole for p in w.passing[ego]):
            slow = a
            while slow - 1 in rows and any(rows[u].a < -0.3 for u in range(slow - 5, slow) if u in rows):
                slow -= 1
            for leaf in ("red_stop", "yellow_stop", "resume_first", "resume_follow"):
                key = slow - 5 if "stop" in leaf else b - 5
                yield w.entry(T + leaf, ego, key - 20, key, (a if "stop" in leaf else b) + 10, optional=True)
