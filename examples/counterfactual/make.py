"""Counterfactual ground truth from SUMO: what the ego would have done without one object.

One scene is driven to the keyframe and its state is saved. From that one state it is driven on for 8 s with everything,
and once more without each object (removed) or with the light forced to green. Drivers are perfect (sigma 0), and are
Krauss, EIDM and ACC, none of them the model that `whyroad_label::counterfactual` fits (IDM).

    pip install eclipse-sumo==1.28.0
    python3 make.py            # writes pairs.jsonl beside this file, equal bytes each time

One line of pairs.jsonl is a scene: leaf, driver, history and future of the ego and of the objects every 0.5 s (position
of the box center along and beside the ego's lane, in decimeters), light, and for each removed thing how much farther the
ego came in 8 s, in decimeters.
"""
import json, os, random, subprocess, sys, tempfile
import sumo

HOME = os.path.dirname(sumo.__file__)
os.environ["SUMO_HOME"] = HOME
sys.path.insert(0, os.path.join(HOME, "tools"))
import traci  # noqa: E402

STEP, BEFORE, AFTER, EVERY = 0.1, 6.0, 8.0, 5
LINE = 600.0  # the stop line
MODELS = {
    "Krauss": 'carFollowModel="Krauss" sigma="0" accel="1.8" decel="3.0" tau="1.2" minGap="2"',
    "EIDM": 'carFollowModel="EIDM" sigmaleader="0" sigmagap="0" sigmaerror="0" accel="1.6" decel="2.5" tau="1.3" minGap="2"',
    "ACC": 'carFollowModel="ACC" accel="1.6" decel="3.0" tau="1.3" minGap="2"',
}


def network(folder):
    """A street of two lanes a direction that crosses another at a light, with a crosswalk-like side entry."""
    nodes = '<nodes><node id="a" x="0" y="0"/><node id="j" x="610" y="0" type="traffic_light"/><node id="b" x="1400" y="0"/>' \
            '<node id="n" x="610" y="200"/><node id="s" x="610" y="-200"/></nodes>'
    edges = "<edges>" + "".join(
        f'<edge id="{i}" from="{f}" to="{t}" numLanes="{n}" speed="{v}"/>'
        for i, f, t, n, v in [("aj", "a", "j", 2, 16.7), ("jb", "j", "b", 2, 16.7), ("ja", "j", "a", 2, 16.7), ("bj", "b", "j", 2, 16.7),
                              ("nj", "n", "j", 1, 13.9), ("js", "j", "s", 1, 13.9), ("sj", "s", "j", 1, 13.9), ("jn", "j", "n", 1, 13.9)]) + "</edges>"
    for name, text in (("n.nod.xml", nodes), ("e.edg.xml", edges)):
        open(os.path.join(folder, name), "w").write(text)
    net = os.path.join(folder, "net.xml")
    subprocess.run([os.path.join(HOME, "bin", "netconvert"), "-n", os.path.join(folder, "n.nod.xml"), "-e", os.path.join(folder, "e.edg.xml"),
                    "-o", net, "--no-turnarounds", "true"], check=True, capture_output=True)
    return net


def crossing_network(folder):
    """A street of one lane a direction with pavements and a crosswalk without lights, where people have priority."""
    nodes = '<nodes><node id="a" x="0" y="0"/><node id="c" x="610" y="0" type="priority"/><node id="b" x="1400" y="0"/></nodes>'
    edges = "<edges>" + "".join(f'<edge id="{i}" from="{f}" to="{t}" numLanes="1" speed="16.7" sidewalkWidth="2"/>'
                                for i, f, t in [("ac", "a", "c"), ("cb", "c", "b"), ("ca", "c", "a"), ("bc", "b", "c")]) + "</edges>"
    crossings = '<connections><crossing node="c" edges="ac ca" priority="true" width="4"/></connections>'
    for name, text in (("c.nod.xml", nodes), ("c.edg.xml", edges), ("c.con.xml", crossings)):
        open(os.path.join(folder, name), "w").write(text)
    net = os.path.join(folder, "crossing.xml")
    subprocess.run([os.path.join(HOME, "bin", "netconvert"), "-n", os.path.join(folder, "c.nod.xml"), "-e", os.path.join(folder, "c.edg.xml"),
                    "-x", os.path.join(folder, "c.con.xml"), "-o", net, "--no-turnarounds", "true"], check=True, capture_output=True)
    return net


class Scene:
    def __init__(self, net, folder, leaf, model, rng):
        self.leaf, self.model, self.rng = leaf, model, rng
        self.ego_speed = rng.uniform(9, 15)
        routes = os.path.join(folder, "r.rou.xml")
        attributes = MODELS[model]
        open(routes, "w").write(
            f'<routes><vType id="ego" {attributes} length="4.6" width="1.9" maxSpeed="{self.ego_speed:.2f}"/>'
            '<vType id="car" sigma="0" length="4.5" width="1.8"/>'
            '<vType id="truck" vClass="truck" sigma="0" length="9" width="2.5"/>'
            + ('<route id="r" edges="ac cb"/><route id="back" edges="bc ca"/></routes>' if leaf == "crossing"
               else '<route id="r" edges="aj jb"/><route id="back" edges="bj ja"/></routes>'))
        traci.start([os.path.join(HOME, "bin", "sumo"), "-n", net, "-r", routes, "--step-length", str(STEP), "--no-step-log", "true",
                     "--no-warnings", "true", "--collision.action", "none", "--time-to-teleport", "-1", "--seed", "1",
                     "--default.speeddev", "0", "--save-state.transportables", "true"], stdout=subprocess.DEVNULL)

    def put(self, name, x, lane, speed, kind="car", route="r", edge="aj"):
        traci.vehicle.add(name, route, typeID=kind, departPos=str(x), departLane=str(lane), departSpeed=str(round(speed, 2)))
        traci.vehicle.setLaneChangeMode(name, 0)
        traci.vehicle.setMaxSpeed(name, max(speed, 0.1))

    def build(self):
        """Puts the ego and the objects on the road; `moves` are what they are told from the keyframe on."""
        r, v = self.rng, self.ego_speed
        if self.leaf == "crossing":
            ego_x = 605 - r.uniform(35, 60) - BEFORE * v
            self.put("ego", ego_x, 1, v, "ego")
            self.moves = []
            # Reaches the curb about when the ego sees to it, and somebody who stays on the other pavement.
            traci.person.add("o1", "ac", 606 - 1.3 * (BEFORE + r.uniform(0.0, 2.0)))
            traci.person.appendWalkingStage("o1", ["ac", "ca"], 540)
            traci.person.setSpeed("o1", 1.3)
            traci.person.add("o2", "ca", 60)
            traci.person.appendWalkingStage("o2", ["ca"], 500)
            self.put("o3", r.uniform(100, 300), 1, r.uniform(8, 12), "car", "back", "bc")
            return
        light = self.leaf.startswith("light")
        ego_x = LINE - r.uniform(70, 120) - BEFORE * v if light else 60.0
        traci.trafficlight.setProgram("j", "0")
        state = traci.trafficlight.getRedYellowGreenState("j")
        self.green, self.red = "G" * len(state), "r" * len(state)
        traci.trafficlight.setRedYellowGreenState("j", self.red if light else self.green)
        self.put("ego", ego_x, 0, v, "ego")
        self.moves = []
        front = ego_x + BEFORE * v  # where a free ego is at the keyframe
        if self.leaf == "following":
            slow = r.uniform(0.3, 0.75) * v
            self.put("o1", front + r.uniform(25, 45) - BEFORE * slow, 0, slow)
        if self.leaf == "cut_in":
            slow = r.uniform(0.4, 0.75) * v
            self.put("o1", front + r.uniform(10, 22) - BEFORE * slow, 1, slow)
            self.moves.append(("o1", "lane", r.uniform(0.0, 1.0), 0))
        if self.leaf == "lead_stops":
            self.put("o1", front + r.uniform(22, 40) - BEFORE * v, 0, v)
            self.moves.append(("o1", "stop", 0.0, r.uniform(3.0, 5.0)))
        if self.leaf == "light_lead":
            gap = r.uniform(8, 16)
            self.put("o1", LINE - gap, 0, 0.0)
        if self.leaf in ("light", "light_lead", "following", "cut_in", "lead_stops"):
            # Somebody beside the ego who has nothing to do with it.
            other = r.uniform(0.8, 1.0) * v
            if self.leaf != "cut_in":
                self.put("o2", max(front + r.uniform(-25, 30) - BEFORE * other, 5), 1, other, "truck" if r.random() < 0.4 else "car")
            self.put("o3", r.uniform(200, 500), r.randint(0, 1), r.uniform(8, 14), "car", "back", "bj")

    def row(self):
        out = {}
        for name in traci.vehicle.getIDList():
            x, y = traci.vehicle.getPosition(name)
            length = traci.vehicle.getLength(name)
            angle = traci.vehicle.getAngle(name)
            direction = 1 if 45 < angle < 135 else -1
            out[name] = (round(10 * (x - direction * length / 2)), round(10 * y), round(10 * traci.vehicle.getSpeed(name)))
        for name in traci.person.getIDList():
            x, y = traci.person.getPosition(name)
            out[name] = (round(10 * x), round(10 * y), round(10 * traci.person.getSpeed(name)))
        return out

    def drive(self, steps, moves):
        rows = []
        for i in range(steps):
            t = i * STEP
            for name, what, at, value in moves:
                if abs(t - at) < STEP / 2 and name in traci.vehicle.getIDList():
                    if what == "lane":
                        traci.vehicle.changeLane(name, int(value), 60)
                    elif what == "stop":
                        traci.vehicle.slowDown(name, 0, max(traci.vehicle.getSpeed(name) / value, 0.5))
                        traci.vehicle.setMaxSpeed(name, 0.05)
            if i % EVERY == 0:
                rows.append(self.row())
            traci.simulationStep()
        rows.append(self.row())
        return rows


def scene(net, folder, leaf, model, rng):
    s = Scene(net, folder, leaf, model, rng)
    try:
        s.build()
        history = s.drive(int(BEFORE / STEP), [])
        if "ego" not in history[-1]:
            return None
        saved = os.path.join(folder, "state.xml")
        traci.simulation.saveState(saved)
        names = sorted(list(traci.vehicle.getIDList()) + list(traci.person.getIDList()))
        future = s.drive(int(AFTER / STEP), s.moves)
        if "ego" not in future[-1]:
            return None
        things = [n for n in names if n != "ego"]
        light = leaf.startswith("light")
        effects = {}
        for thing in things + (["light"] if light else []):
            traci.simulation.loadState(saved)
            for n in traci.vehicle.getIDList():
                traci.vehicle.setLaneChangeMode(n, 0)
            if leaf != "crossing":
                traci.trafficlight.setRedYellowGreenState("j", s.red if light else s.green)
            if thing == "light":
                traci.trafficlight.setRedYellowGreenState("j", s.green)
            elif thing in traci.person.getIDList():
                traci.person.remove(thing)
            else:
                traci.vehicle.remove(thing)
            without = s.drive(int(AFTER / STEP), [m for m in s.moves if m[0] != thing])
            if "ego" not in without[-1]:
                return None
            effects[thing] = without[-1]["ego"][0] - future[-1]["ego"][0]
        tracks = {}
        for name in ["ego"] + things:
            tracks[name] = [list(row[name][:2]) if name in row else None for row in history[:-1] + future]
        speeds = [row["ego"][2] if "ego" in row else None for row in history[:-1] + future]
        return {"leaf": leaf, "driver": model, "keyframe": len(history) - 1, "tracks": tracks, "speeds": speeds,
                "line": round(10 * LINE) if light else None, "effects": effects}
    finally:
        traci.close()


def main():
    rng, out = random.Random(20260115), []
    with tempfile.TemporaryDirectory() as folder:
        nets = {False: network(folder), True: crossing_network(folder)}
        for leaf in ("following", "cut_in", "lead_stops", "crossing", "light", "light_lead"):
            net = nets[leaf == "crossing"]
            for model in MODELS:
                made = 0
                while made < 10:
                    found = scene(net, folder, leaf, model, rng)
                    if found:
                        out.append(json.dumps(found, separators=(",", ":")))
                        made += 1
    path = os.path.join(sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.abspath(__file__)), "pairs.jsonl")
    open(path, "w").write("\n".join(out) + "\n")
    pairs = sum(len(json.loads(l)["effects"]) for l in out)
    print(len(out), "scenes,", pairs, "pairs")


if __name__ == "__main__":
    main()
