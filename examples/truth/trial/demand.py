"""Drivers, vehicles and trips of the trial, drawn from a seed. Egos are passenger cars of the traffic like any
other.
"""

import re

MODEL = {
    "Krauss": 'carFollowModel="Krauss" sigma="0.4"',
    "IDM": 'carFollowModel="IDM" delta="4" sigma="0"',
    "EIDM": 'carFollowModel="EIDM"',
    "ACC": 'carFollowModel="ACC"',
    "W99": 'carFollowModel="W99"',
    "W74": 'carFollowModel="Wiedemann"',
    "IDMM": 'carFollowModel="IDMM" adaptFactor="1.6" adaptTime="300"',
    "CACC": 'carFollowModel="CACC"',
    "Orig1": 'carFollowModel="KraussOrig1" sigma="0.3"',
    "Wagner": 'carFollowModel="PWagner2009"',
    "KraussPS": 'carFollowModel="KraussPS" sigma="0.6"',
    "IDM2": 'carFollowModel="IDM" delta="2"',
    "Kerner": 'carFollowModel="BKerner" k="0.8" phi="4"',
    "IDM3": 'carFollowModel="IDM" delta="6" stepping="0.2" sigma="0"',
    "W99b": 'carFollowModel="W99" cc1="1.1" cc2="6" cc4="-0.5" cc5="0.5"',
    "Orig2": 'carFollowModel="KraussOrig1" sigma="0.6"',
    "ACC2": 'carFollowModel="ACC" speedControlGain="-0.3" gapClosingControlGainSpeed="0.6"',
    "EIDM2": 'carFollowModel="EIDM" tpreview="3" treaction="0.8" epsilon="1"',
    "KraussX": 'carFollowModel="KraussX" sigma="0.35"',
    "IDM4": 'carFollowModel="IDM" delta="3" stepping="0.1" sigma="0.15"',
    "EIDM3": 'carFollowModel="EIDM" tpreview="5" treaction="0.3" tpersdrive="4" ccoolness="0.9"',
    "W99c": 'carFollowModel="W99" cc1="1.4" cc2="3" cc7="0.4" cc8="2.5"',
    "Daniel": 'carFollowModel="Daniel1"',
    "IDMM2": 'carFollowModel="IDMM" adaptFactor="1.3" adaptTime="120" delta="5"',
    "CACC2": 'carFollowModel="CACC" speedControlGainCACC="-0.3" gapClosingControlGainGap="0.01"',
    "EIDM4": 'carFollowModel="EIDM" tpreview="2" treaction="0.6" ccoolness="0.7" sigmagap="0.2"',
    "KraussLate": 'carFollowModel="Krauss" sigma="0.2" tau="1.5" actionStepLength="0.5" startupDelay="0.7" lcStrategic="1.6" lcKeepRight="0.2"',
    "IDM5": 'carFollowModel="IDM" delta="5" tau="1.3" actionStepLength="0.2" lcOpposite="1.5" lcSpeedGain="3" speedFactor="normc(1.05,0.12,0.8,1.35)"',
    "IDM6": 'carFollowModel="IDM" delta="3" tau="1.2" sigma="0" actionStepLength="0.4" lcCooperative="0.5"',
    "KraussHasty": 'carFollowModel="Krauss" sigma="0.55" tau="1.0" decel="5" impatience="0.4" jmTimegapMinor="0.8"',
    "EIDM5": 'carFollowModel="EIDM" tau="1.0" treaction="0.4" tpreview="4" speedFactor="normc(1.08,0.1,0.85,1.35)" lcSpeedGain="2" lcStrategic="1.3"',
    "KraussCalm": 'carFollowModel="Krauss" sigma="0.3" tau="1.4" accel="1.8" decel="3.4" jmTimegapMinor="1.4" jmStoplineGap="1.5"',
    "IDM7": 'carFollowModel="IDM" delta="4" tau="1.4" actionStepLength="0.6" lcCooperative="0.8" lcKeepRight="0.6"',
    "KraussTown": 'carFollowModel="Krauss" sigma="0.45" tau="1.1" decel="4.6" impatience="0.2" jmTimegapMinor="1.1" speedFactor="normc(1.04,0.08,0.85,1.25)"',
    "IDM8": 'carFollowModel="IDM" delta="4" tau="1.0" sigma="0" lcAssertive="2.5" lcSpeedGain="2" lcCooperative="0.4" speedFactor="normc(1.0,0.17,0.7,1.35)"',
    "EIDM6": 'carFollowModel="EIDM" tau="1.2" decel="2.8" treaction="0.5" tpreview="4" lcSpeedGain="2" lcStrategic="1.4" jmTimegapMinor="1.2"',
    "ACC3": 'carFollowModel="ACC" tau="1.3" gapClosingControlGainSpeed="0.7" lcOpposite="2" lcSpeedGain="5" speedFactor="normc(1.08,0.1,0.9,1.35)"',
    "KraussSlow": 'carFollowModel="KraussPS" sigma="0.25" tau="1.2" startupDelay="0.5" speedFactor="normc(0.96,0.07,0.8,1.15)"',
    "KraussFirm": 'carFollowModel="Krauss" sigma="0.25" tau="0.95" decel="4.2" lcAssertive="1.6" lcSpeedGain="2.5" lcCooperative="0.7" speedFactor="normc(1.02,0.12,0.75,1.3)"',
    "EIDM7": 'carFollowModel="EIDM" tau="1.15" accel="2.1" decel="3.2" treaction="0.35" tpreview="3.5" startupDelay="0.4" lcStrategic="1.5" lcSpeedGain="1.8" lcMaxSpeedLatStanding="0" lcMaxSpeedLatFactor="0.25" speedFactor="normc(1.05,0.09,0.85,1.3)"',
    "KraussLane": 'carFollowModel="KraussPS" sigma="0.35" tau="1.05" decel="5.2" jmTimegapMinor="1.2" jmStoplineGap="0.8" impatience="0.1" speedFactor="normc(1.0,0.09,0.8,1.25)"',
    "KraussBrisk": 'carFollowModel="Krauss" sigma="0.2" tau="1.05" accel="2.7" decel="3.0" jmTimegapMinor="1.0" jmStoplineGap="1.2" lcStrategic="1.3" lcSpeedGain="1.5" speedFactor="normc(1.03,0.09,0.82,1.28)"',
    "IDM10": 'carFollowModel="IDM" delta="4.5" tau="1.25" sigma="0" lcAssertive="1.5" lcSpeedGain="2.2" lcCooperative="0.8" lcKeepRight="0.8" speedFactor="normc(1.0,0.14,0.75,1.25)"',
    "KraussDense": 'carFollowModel="Krauss" sigma="0.2" tau="1.0" decel="3.6" lcAssertive="1.8" lcSpeedGain="2.5" lcCooperative="0.6" speedFactor="normc(1.0,0.14,0.72,1.32)"',
    "EIDM8": 'carFollowModel="EIDM" tau="1.25" accel="2.0" decel="3.0" treaction="0.45" tpreview="3" ccoolness="0.95" startupDelay="0.4" jmTimegapMinor="0.9" speedFactor="normc(0.98,0.1,0.78,1.25)"',
    "KraussFresh": 'carFollowModel="Krauss" sigma="0.3" tau="1.15" accel="2.3" decel="3.8" jmTimegapMinor="1.2" lcStrategic="1.4" lcSpeedGain="1.8" speedFactor="normc(1.01,0.1,0.8,1.28)"',
    "IDM11": 'carFollowModel="IDM" delta="4" tau="1.15" sigma="0" lcAssertive="1.7" lcSpeedGain="2.4" lcCooperative="0.7" lcKeepRight="0.5" speedFactor="normc(1.0,0.13,0.74,1.28)"',
    "EIDM9": 'carFollowModel="EIDM" tau="1.1" accel="2.2" decel="3.4" treaction="0.4" tpreview="4" ccoolness="0.9" startupDelay="0.3" lcStrategic="1.5" lcSpeedGain="1.6" jmTimegapMinor="1.0" speedFactor="normc(1.02,0.1,0.8,1.25)"',
    "KraussEven": 'carFollowModel="KraussPS" sigma="0.2" tau="1.2" accel="2.1" decel="3.5" jmTimegapMinor="1.1" jmStoplineGap="1.0" startupDelay="0.3" speedFactor="normc(1.0,0.1,0.78,1.25)"',
    "EIDM10": 'carFollowModel="EIDM" tau="1.2" accel="2.3" decel="3.3" treaction="0.35" tpreview="4" ccoolness="0.92" startupDelay="0.35" lcStrategic="1.4" lcSpeedGain="1.9" lcAssertive="1.3" jmTimegapMinor="1.1" speedFactor="normc(1.0,0.11,0.8,1.26)"',
    "IDM12": 'carFollowModel="IDM" delta="4" tau="1.2" sigma="0" lcAssertive="1.6" lcSpeedGain="2.6" lcCooperative="0.75" lcKeepRight="0.7" speedFactor="normc(1.01,0.13,0.74,1.3)"',
    "KraussPlain": 'carFollowModel="Krauss" sigma="0.25" tau="1.1" accel="2.2" decel="3.6" jmTimegapMinor="1.1" lcStrategic="1.5" lcSpeedGain="2" lcCooperative="0.8" startupDelay="0.4" speedFactor="normc(1.0,0.11,0.78,1.28)"',
    "KraussTame": 'carFollowModel="KraussPS" sigma="0.3" tau="1.25" accel="1.9" decel="3.4" jmTimegapMinor="1.3" jmStoplineGap="1.0" startupDelay="0.4" speedFactor="normc(0.97,0.09,0.78,1.2)"',
    "KraussKeen": 'carFollowModel="Krauss" sigma="0.2" tau="1.0" accel="2.5" decel="4.0" jmTimegapMinor="1.0" lcStrategic="1.4" lcSpeedGain="1.7" lcAssertive="1.4" startupDelay="0.3" speedFactor="normc(1.02,0.1,0.8,1.27)"',
    "EIDM11": 'carFollowModel="EIDM" tau="1.15" accel="2.1" decel="3.2" treaction="0.4" tpreview="3.5" ccoolness="0.9" startupDelay="0.45" lcStrategic="1.5" lcSpeedGain="1.7" jmTimegapMinor="1.2" speedFactor="normc(0.99,0.1,0.8,1.24)"',
    "KraussWary": 'carFollowModel="KraussPS" sigma="0.25" tau="1.3" accel="2.2" decel="3.7" jmTimegapMinor="1.4" jmStoplineGap="1.0" startupDelay="0.35" lcSpeedGain="1.6" speedFactor="normc(1.0,0.12,0.76,1.26)"',
    "IDM13": 'carFollowModel="IDM" delta="4.2" tau="1.1" sigma="0" lcAssertive="1.8" lcSpeedGain="2.3" lcCooperative="0.85" lcKeepRight="0.6" speedFactor="normc(1.0,0.12,0.75,1.28)"',
    "EIDM12": 'carFollowModel="EIDM" tau="1.1" accel="2.2" decel="3.5" treaction="0.35" tpreview="3.5" ccoolness="0.94" startupDelay="0.3" lcStrategic="1.4" lcSpeedGain="1.5" jmTimegapMinor="1.1" jmStoplineGap="1.0" speedFactor="normc(0.98,0.1,0.78,1.22)"',
    "IDM14": 'carFollowModel="IDM" delta="4" tau="1.15" sigma="0" lcAssertive="1.9" lcSpeedGain="2.5" lcCooperative="0.8" lcKeepRight="0.9" speedFactor="normc(1.0,0.14,0.74,1.3)"',
    "KraussCivil": 'carFollowModel="KraussPS" sigma="0.2" tau="1.15" accel="2.1" decel="3.8" jmTimegapMinor="1.2" lcStrategic="1.6" lcSpeedGain="1.6" lcCooperative="0.9" startupDelay="0.45" speedFactor="normc(0.99,0.09,0.8,1.22)"',
    "KraussNight": 'carFollowModel="Krauss" sigma="0.15" tau="1.3" accel="2.6" decel="3.9" jmTimegapMinor="1.0" jmStoplineGap="1.3" lcSpeedGain="2.2" startupDelay="0.5" speedFactor="normc(1.06,0.13,0.78,1.38)"',
    "IDM15": 'carFollowModel="IDM" delta="4" tau="1.05" sigma="0" lcAssertive="1.7" lcSpeedGain="2.4" lcCooperative="0.8" lcKeepRight="0.3" speedFactor="normc(1.02,0.13,0.74,1.3)"',
    "EIDM13": 'carFollowModel="EIDM" tau="1.05" accel="2.3" decel="3.4" treaction="0.35" tpreview="3.5" ccoolness="0.93" startupDelay="0.35" lcStrategic="1.5" lcSpeedGain="1.7" jmTimegapMinor="1.1" speedFactor="normc(1.0,0.1,0.8,1.24)"',
    "KraussSure": 'carFollowModel="Krauss" sigma="0.2" tau="1.1" accel="2.4" decel="3.9" jmTimegapMinor="1.0" lcStrategic="1.4" lcSpeedGain="1.9" startupDelay="0.35" speedFactor="normc(1.0,0.11,0.78,1.25)"',
    "KraussPlains": 'carFollowModel="Krauss" sigma="0.2" tau="1.2" accel="2.3" decel="3.6" jmTimegapMinor="1.2" jmStoplineGap="1.0" lcOpposite="0.9" lcSpeedGain="2" startupDelay="0.4" speedFactor="normc(1.03,0.1,0.82,1.3)"',
    "EIDM14": 'carFollowModel="EIDM" tau="1.2" accel="2.1" decel="3.3" treaction="0.4" tpreview="4" ccoolness="0.91" startupDelay="0.4" lcStrategic="1.3" lcSpeedGain="1.6" jmTimegapMinor="1.2" jmStoplineGap="1.0" speedFactor="normc(0.99,0.1,0.8,1.23)"',
    "KraussBrief": 'carFollowModel="Krauss" sigma="0.25" tau="1.0" accel="2.5" decel="3.8" jmTimegapMinor="1.1" jmStoplineGap="1.0" lcStrategic="1.5" lcSpeedGain="1.8" lcAssertive="1.2" startupDelay="0.3" speedFactor="normc(1.02,0.11,0.8,1.26)"',
    "KraussHill": 'carFollowModel="KraussPS" sigma="0.15" tau="1.25" accel="2.2" decel="3.7" jmTimegapMinor="1.3" jmStoplineGap="1.0" lcSpeedGain="2.2" startupDelay="0.35" speedFactor="normc(1.01,0.1,0.8,1.27)"',
    "IDM16": 'carFollowModel="IDM" delta="4.3" tau="1.1" sigma="0" lcAssertive="1.6" lcSpeedGain="2.3" lcCooperative="0.9" lcKeepRight="0.8" speedFactor="normc(0.98,0.14,0.72,1.25)"',
    "IDM9": 'carFollowModel="IDM" delta="3.5" tau="1.1" sigma="0" lcAssertive="2" lcSpeedGain="3" lcCooperative="0.5" actionStepLength="0.4" speedFactor="normc(0.99,0.15,0.72,1.3)"',
}

# How many of car, quick, van and truck in the traffic of a model, where it is not as elsewhere.
SHARES = {"IDM5": [5, 3, 2, 1.5], "IDM6": [5, 2, 2, 3.5], "IDM7": [4, 2, 2, 5], "IDM8": [4, 3, 2, 4], "EIDM6": [5, 2, 3, 4], "KraussFirm": [5, 3, 2, 2], "IDM9": [4, 3, 2, 5], "IDM12": [5, 3, 2, 3], "IDM13": [5, 3, 2, 4], "IDM14": [5, 2, 2, 4.5], "KraussNight": [4, 3, 2, 3], "IDM15": [5, 3, 2, 2.5], "EIDM13": [5, 2, 2.5, 0.8], "IDM16": [5, 3, 2, 3]}


def types(model, lateral):
    model, _, more = model.partition("+")
    follow = MODEL[model]
    side = ' latAlignment="center" minGapLat="0.5"' if lateral == "sublane" else ""
    return [settled(row) for row in [
        f'<vType id="car" vClass="passenger" length="4.5" width="1.8" minGap="2.2" tau="1.1" accel="2.4" decel="4.0" speedFactor="normc(1.0,0.08,0.8,1.2)" {follow}{side}/>',
        f'<vType id="quick" vClass="passenger" length="4.7" width="1.9" minGap="1.8" tau="0.9" accel="3.0" decel="4.5" speedFactor="normc(1.15,0.06,1.0,1.3)" lcSpeedGain="3" lcAssertive="2" {follow}{side}/>',
        f'<vType id="van" vClass="delivery" length="6.2" width="2.1" minGap="2.5" tau="1.3" accel="1.8" decel="3.6" speedFactor="normc(0.92,0.05,0.8,1.0)" {follow}{side}/>',
        f'<vType id="truck" vClass="truck" length="13.5" width="2.5" minGap="3" tau="1.5" accel="1.0" decel="3.2" maxSpeed="24" {follow}{side}/>',
        f'<vType id="coach" vClass="bus" length="12" width="2.5" minGap="3" tau="1.4" accel="1.2" decel="3.5" maxSpeed="23" {follow}{side}/>',
        f'<vType id="cycle" vClass="bicycle" length="1.7" width="0.6" minGap="0.8" maxSpeed="5.0"{side}/>',
        *([f'<vType id="moto" vClass="motorcycle" length="2.2" width="0.9" minGap="1.5" accel="4" decel="6" speedFactor="normc(1.1,0.1,0.9,1.4)" {follow}{side}/>'] if "moto" in more else []),
        *(['<vType id="tram" vClass="tram" length="32" width="2.4" minGap="3" accel="1.1" decel="2.4" maxSpeed="14" speedFactor="1"/>'] if "tram" in more else []),
        *(['<vType id="train" vClass="rail" length="64" width="2.8" minGap="5" accel="0.7" decel="1.1" sigma="0" maxSpeed="22" speedFactor="1"/>'] if "train" in more else []),
        '<vType id="walker" vClass="pedestrian" length="0.4" width="0.5" speedFactor="normc(1.0,0.12,0.7,1.3)"/>',
    ]]


def settled(row):
    """A type's attribute that its driver's model gives as well is the model's."""
    last = dict(re.findall(r' (\w+)="([^"]*)"', row))
    seen = re.findall(r" (\w+)=", row)
    for name in {n for n in seen if seen.count(n) > 1}:
        row = re.sub(rf' {name}="[^"]*"', "", row, count=seen.count(name) - 1)
        row = re.sub(rf' {name}="[^"]*"', f' {name}="{last[name]}"', row)
    return row


def roads(net, motorway):
    """Where trips may begin and end: the network's rim where it has one, else any road of 60 m or more."""
    usable = [e for e in net.getEdges() if e.allows("passenger") and e.getLength() > (100 if motorway else 50)]
    starts = [e for e in usable if not [i for i in e.getIncoming() if i.getFromNode() is not e.getToNode()]]
    ends = [e for e in usable if not [o for o in e.getOutgoing() if o.getToNode() is not e.getFromNode()]]
    if len(starts) < 2 and not motorway or len(starts) < 1:
        starts = usable
    if len(ends) < 2:
        ends = usable
    return sorted(e.getID() for e in starts), sorted(e.getID() for e in ends)


def trips(draw, net, model, seconds, rate, people, egos):
    motorway = max(e.getSpeed() for e in net.getEdges()) > 25
    starts, ends = roads(net, motorway)
    lanes = {e.getID(): e.getLaneNumber() for e in net.getEdges()}
    rows, chosen = [], 0
    count = int(seconds * rate)
    spacing = max(1, int(count * 0.6 / egos))
    weight = [lanes[s] for s in starts]
    for i in range(count):
        t = i / rate
        while True:
            start, end = draw.choices(starts, weight)[0], draw.choice(ends)
            if start != end and net.getShortestPath(net.getEdge(start), net.getEdge(end))[0]:
                break
        kind = draw.choices(["car", "quick", "van", "truck"], SHARES.get(model.partition("+")[0], [6, 3, 1.5, 1.5 if motorway else 0.6]))[0]
        if "+moto" in model and draw.random() < 0.08:
            kind = "moto"
        ego = 10 < t < seconds - 50 and i % spacing == 0 and chosen < egos
        chosen += ego
        rows.append((t, f'<trip id="{f"ego{chosen}" if ego else f"v{i}"}" type="{"car" if ego and chosen % 3 else "quick" if ego else kind}" depart="{t:.1f}" '
                        f'from="{start}" to="{end}" departLane="{"best" if not motorway else "random"}" departSpeed="{"max" if motorway else "desired"}"/>'))
    if not motorway:
        for i in range(int(seconds / 25)):
            start, end = draw.sample(starts, 2)[0], draw.choice(ends)
            stop = f'<stop lane="{start}_0" endPos="{0.7 * net.getEdge(start).getLength():.0f}" duration="9"/>' if net.getEdge(start).getLane(0).allows("bus") else ""
            rows.append((i * 25 + 4, f'<trip id="b{i}" type="coach" depart="{i * 25 + 4}" from="{start}" to="{end}">{stop}</trip>'))
        barred = any(e.allows("passenger") and not e.allows("bicycle") for e in net.getEdges())
        for i in range(int(seconds / 14)):
            start, end = draw.choice(starts), draw.choice(ends)
            if barred and net.getShortestPath(net.getEdge(start), net.getEdge(end), vClass="bicycle")[0] is None:
                continue
            rows.append((i * 14 + 2, f'<trip id="k{i}" type="cycle" depart="{i * 14 + 2}" from="{start}" to="{end}"/>'))
    walks = sorted(e.getID() for e in net.getEdges() if people and e.allows("pedestrian") and not e.getFunction())
    for i in range(int(seconds * people)):
        start, end = draw.sample(walks, 2)
        rows.append((i / people, f'<person id="p{i}" type="walker" depart="{i / people:.1f}"><walk from="{start}" to="{end}"/></person>'))
    return [text for _, text in sorted(rows, key=lambda r: r[0])], [f"ego{i + 1}" for i in range(chosen)]
