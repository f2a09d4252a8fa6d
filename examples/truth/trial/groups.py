"""The groups of runs: networks, drivers, steps, traffic. Who saw which: docs/explanation/accuracy-simulated.md."""

from functools import partial

from networks import (
    avenue,
    city_grid,
    clover_motorway,
    hill_motorway,
    left_grid,
    left_rings,
    left_spider,
    loop_interchange,
    old_town,
    osm_motorway,
    random_town,
    ring_street,
    ring_town,
    star_town,
    trumpet,
    weave_motorway,
    web_town,
)
from networks_channeled import distributors, pairs, third_lane, turbo
from networks_citadel import highstreet, nightshift, tee, walls
from networks_drawn import circles, country, knotted, motorway, street
from networks_everyday import artery, hill_road, quarter, works
from networks_gateway import airport, diamond, indirect, railside
from networks_joined import dumbbell, herringbone, hexagons, plain_exits
from networks_lakeside import belt, climb, drops, strip
from networks_local import ring_motorway, school, suburb, two_banks
from networks_midland import boulevard, parclo, throughabout, twostage
from networks_mixed import lit_grid, parked, spokes, weaving
from networks_newtown import retail, sideroads, singlepoint, turbine
from networks_outskirts import contraflow, crossings, hamlet, viaduct
from networks_plains import downtown, freeway, gridroads, township
from networks_planned import arterial, collector, estate, one_way_blocks
from networks_regional import gyratory, terminus, tramway, upland
from networks_seaside import coast, docks, expressway, market
from networks_shaped import ladder, oval, parting, river_town

# Name: (maker, seed, seconds, step s, drivers' model, lateral: seconds of a change or "sublane", vehicles per second,
# people)
SETS = {
    "develop": {
        "random": (random_town, 31, 300, 0.1, "IDM", 3, 0.9, 0),
        "web": (web_town, 47, 240, 0.1, "Krauss", "sublane", 0.8, 0),
        "leftgrid": (left_grid, 53, 260, 0.1, "Krauss", 2.5, 0.6, 0.15),
        "avenue": (avenue, 61, 260, 0.05, "EIDM", 3, 0.9, 0),
        "rings": (ring_town, 71, 240, 0.1, "IDM", 2, 0.6, 0),
        "weave": (weave_motorway, 83, 150, 0.1, "EIDM", 4, 1.1, 0),
        "osmway": (osm_motorway, 97, 150, 0.2, "ACC", 3, 1.3, 0),
        "loops": (loop_interchange, 103, 150, 0.1, "Krauss", 3, 1.4, 0),
    },
    "held": {
        "citygrid": (city_grid, 1031, 260, 0.1, "EIDM", 3, 0.8, 0.2),
        "oldtown": (old_town, 1049, 260, 0.05, "IDM", 3, 0.6, 0),
        "leftrings": (left_rings, 1061, 240, 0.1, "Krauss", 3, 0.45, 0),
        "star": (star_town, 1069, 240, 0.1, "ACC", 2.5, 0.6, 0),
        "clover": (clover_motorway, 1087, 150, 0.2, "Krauss", 3, 0.9, 0),
        "hillway": (hill_motorway, 1091, 150, 0.1, "IDM", "sublane", 1.2, 0),
    },
    "held2": {
        "trumpet": (trumpet, 2027, 170, 0.1, "W99", 3.5, 1.1, 0),
        "leftspider": (left_spider, 2029, 240, 0.2, "ACC", 3, 0.7, 0),
        "ringstreet": (ring_street, 2039, 240, 0.1, "EIDM", "sublane", 0.7, 0.15),
    },
    "varied": {
        "street": (street, 3001, 220, 0.1, "IDM+moto", 3, 0.7, 0.2),
        "leftway": (partial(motorway, left=True, pieces=("entry", "plain_exit", "weave", "exit")), 3011, 150, 0.1, "EIDM", 3, 1.0, 0),
        "circles": (partial(circles, left=True), 3019, 200, 0.2, "Krauss+moto", 2.5, 0.5, 0),
        "country": (country, 3023, 200, 0.1, "ACC", 3, 0.35, 0),
        "knotted": (knotted, 3037, 220, 0.1, "W74", 2, 0.6, 0),
    },
    "held3": {
        "leftstreet": (partial(street, left=True, limit=16.67, lanes=(1, 2), controls=("traffic_light", "priority", "right_before_left"), gap=(60, 130), count=5, slots=True), 4003, 220, 0.2, "EIDM+moto", 2, 0.6, 0.15),
        "autobahn": (partial(motorway, pieces=("weave", "added", "exit", "plain_exit", "drop", "entry"), lanes=2, limit=36.11, typed=False), 4013, 150, 0.1, "W99", 4, 1.0, 0),
        "rounds": (partial(circles, count=3, walks=True), 4021, 200, 0.1, "IDM+moto", "sublane", 0.5, 0.1),
        "leftcountry": (partial(country, left=True), 4027, 200, 0.05, "Krauss", 3, 0.35, 0),
        "knots": (partial(knotted, left=False), 4049, 220, 0.1, "ACC+moto", 2.5, 0.6, 0),
    },
    "held4": {
        "blocks": (one_way_blocks, 5003, 220, 0.1, "Orig1+moto", 3, 0.7, 0.15),
        "estate": (estate, 5009, 220, 0.1, "IDMM", 2.5, 0.45, 0.15),
        "arterial": (arterial, 5011, 220, 0.05, "Wagner+moto", 3.5, 0.6, 0),
        "collector": (collector, 5021, 160, 0.1, "CACC", "sublane", 0.9, 0),
    },
    "held5": {
        "ladder": (ladder, 6007, 220, 0.1, "KraussPS+moto", 3, 0.55, 0.12),
        "parting": (parting, 6011, 160, 0.1, "IDM2", 3.5, 1.1, 0),
        "oval": (oval, 6029, 220, 0.1, "Kerner", 2.5, 0.55, 0.1),
        "rivertown": (river_town, 6037, 220, 0.05, "EIDM2+moto", "sublane", 0.6, 0.15),
    },
    "held6": {
        "spokes": (spokes, 7001, 220, 0.1, "IDM3+moto", 2.5, 0.5, 0.15),
        "litgrid": (lit_grid, 7013, 220, 0.1, "W99b", 3, 0.8, 0.1),
        "weaving": (weaving, 7019, 150, 0.1, "Orig2", 3, 1.0, 0),
        "parked": (parked, 7027, 220, 0.1, "ACC2+moto", 2.5, 0.5, 0.2),
    },
    "held7": {
        "herringbone": (herringbone, 8009, 220, 0.1, "KraussX+moto", 2.5, 0.7, 0.12),
        "plainexits": (plain_exits, 8011, 150, 0.1, "IDM4", 4, 1.1, 0),
        "dumbbell": (dumbbell, 8017, 220, 0.2, "EIDM3", 3, 0.6, 0),
        "hexagons": (hexagons, 8039, 220, 0.1, "W99c+moto", "sublane", 0.6, 0.12),
    },
    "held8": {
        "turbo": (turbo, 9001, 220, 0.1, "Daniel+moto", 2.5, 0.6, 0.15),
        "distributors": (distributors, 9007, 200, 0.2, "IDMM2", 3.5, 1.5, 0),
        "thirdlane": (third_lane, 9011, 240, 0.05, "CACC2", 3, 0.55, 0),
        "pairs": (pairs, 9013, 240, 0.1, "EIDM4+moto", "sublane", 0.55, 0.2),
    },
    "held9": {
        "artery": (artery, 20011, 240, 0.1, "KraussLate+moto", 3, 0.95, 0.1),
        "hillroad": (hill_road, 10009, 240, 0.1, "IDM5+moto", 2.5, 0.42, 0.1),
        "works": (works, 20021, 200, 0.2, "IDM6", 4, 1.5, 0),
        "quarter": (quarter, 10039, 240, 0.05, "KraussHasty+moto", "sublane", 0.6, 0.25),
    },
    "held10": {
        "suburb": (suburb, 11003, 300, 0.1, "EIDM5+moto", 3, 0.55, 0),
        "school": (school, 11027, 280, 0.1, "KraussCalm", 2.5, 0.32, 0.25),
        "ringway": (ring_motorway, 11047, 190, 0.2, "IDM7", 4, 1.3, 0),
        "twobanks": (two_banks, 11057, 260, 0.05, "KraussSlow+moto", "sublane", 0.4, 0.1),
    },
    "held11": {
        "market": (market, 12007, 280, 0.1, "KraussTown+moto", "sublane", 0.6, 0.1),
        "expressway": (expressway, 12011, 200, 0.2, "IDM8", 3, 2.1, 0),
        "docks": (docks, 12037, 300, 0.1, "EIDM6", 3.5, 0.46, 0),
        "coast": (coast, 12041, 280, 0.1, "ACC3+moto", 3, 0.5, 0.05),
    },
    "held12": {
        "viaduct": (viaduct, 13001, 260, 0.1, "KraussFirm+moto", 3.2, 1.05, 0),
        "crossings": (crossings, 13003, 300, 0.1, "EIDM7+moto", "sublane", 0.55, 0),
        "hamlet": (hamlet, 13013, 280, 0.05, "KraussLane+moto", 2.5, 0.45, 0),
        "contraflow": (contraflow, 13009, 220, 0.2, "IDM9", 4.5, 1.5, 0),
    },
    "held13": {
        "tramway": (tramway, 14009, 280, 0.1, "EIDM8+moto+tram", 2.8, 0.42, 0.1),
        "gyratory": (gyratory, 14011, 240, 0.1, "IDM10", 3.3, 0.72, 0),
        "terminus": (terminus, 14029, 230, 0.2, "KraussDense", 4, 1.15, 0),
        "upland": (upland, 14033, 320, 0.05, "KraussBrisk+moto", "sublane", 0.24, 0.06),
    },
    "held14": {
        "indirect": (indirect, 15013, 300, 0.1, "KraussFresh+moto", "sublane", 0.62, 0),
        "diamond": (diamond, 15017, 240, 0.2, "IDM11", 3.6, 0.9, 0),
        "airport": (airport, 15031, 280, 0.1, "EIDM9", 2.7, 0.42, 0),
        "railside": (railside, 15053, 320, 0.05, "KraussEven+moto+train", 3.2, 0.42, 0),
    },
    "held15": {
        "sideroads": (sideroads, 16001, 300, 0.1, "EIDM10+moto", "sublane", 0.75, 0),
        "turbine": (turbine, 16007, 230, 0.2, "IDM12", 3.8, 1.55, 0),
        "singlepoint": (singlepoint, 16033, 270, 0.1, "KraussPlain", 3.4, 0.8, 0),
        "retail": (retail, 16057, 310, 0.05, "KraussTame+moto", 2.6, 0.34, 0),
    },
    "held16": {
        "throughabout": (throughabout, 17011, 290, 0.1, "KraussKeen+moto", 3, 0.4, 0),
        "boulevard": (boulevard, 17021, 290, 0.05, "EIDM11+moto", "sublane", 0.27, 0.1),
        "twostage": (twostage, 17029, 300, 0.1, "KraussWary+moto", 3.5, 0.4, 0),
        "parclo": (parclo, 17033, 230, 0.2, "IDM13", 4.2, 1.2, 0),
    },
    "held17": {
        "walls": (walls, 18013, 300, 0.1, "EIDM12+moto", "sublane", 0.3, 0.12),
        "tee": (tee, 18041, 240, 0.2, "IDM14", 3.4, 1.35, 0),
        "highstreet": (highstreet, 18043, 300, 0.1, "KraussCivil+moto", 2.8, 0.4, 0),
        "nightshift": (nightshift, 18061, 320, 0.05, "KraussNight+moto", 3.2, 0.2, 0),
    },
    "held18": {
        "freeway": (freeway, 19001, 240, 0.2, "IDM15", 3.5, 0.7, 0),
        "downtown": (downtown, 19009, 300, 0.1, "EIDM13+moto", "sublane", 0.22, 0.08),
        "gridroads": (gridroads, 19013, 290, 0.1, "KraussSure+moto", 3, 0.3, 0),
        "township": (township, 19031, 310, 0.05, "KraussPlains+moto", 3.3, 0.2, 0.04),
    },
    "held19": {
        "belt": (belt, 21001, 215, 0.1, "EIDM14+moto", "sublane", 0.25, 0),
        "strip": (strip, 21011, 225, 0.1, "KraussBrief+moto", 3, 0.3, 0),
        "climb": (climb, 21013, 230, 0.2, "KraussHill+moto", 2.9, 0.28, 0),
        "drops": (drops, 21017, 160, 0.2, "IDM16", 3.7, 0.7, 0),
    },
}

# What is recorded of the runs of a group, or of one run, is noisy: deviations of a position of one frame, and of 1 s
# (m); of a speed (m/s); of a heading (degrees); the share of rows of others that are lost. The truth is of what
# happened.
NOISE = {
    "held4": (0.04, 0.08, 0.15, 0.0, 0.0),
    "held5": (0.07, 0.04, 0.2, 1.0, 0.02),
    "held6/litgrid": (0.04, 0.08, 0.15, 0.0, 0.0),
    "held6/parked": (0.04, 0.08, 0.15, 0.0, 0.0),
    "held7/herringbone": (0.05, 0.1, 0.1, 0.5, 0.01),
    "held7/plainexits": (0.08, 0.05, 0.25, 0.5, 0.03),
    "held8/turbo": (0.03, 0.12, 0.12, 1.5, 0.04),
    "held8/distributors": (0.12, 0.03, 0.3, 0.3, 0.05),
    "held9/artery": (0.1, 0.15, 0.2, 0.8, 0.06),
    "held9/works": (0.02, 0.06, 0.4, 2.0, 0.08),
    "held10/suburb": (0.06, 0.1, 0.25, 1.2, 0.05),
    "held10/ringway": (0.15, 0.04, 0.2, 0.6, 0.07),
    "held11/docks": (0.08, 0.12, 0.18, 1.0, 0.06),
    "held11/coast": (0.05, 0.2, 0.3, 1.6, 0.04),
    "held12/viaduct": (0.07, 0.16, 0.22, 1.3, 0.05),
    "held12/crossings": (0.1, 0.07, 0.28, 0.7, 0.03),
    "held13/gyratory": (0.05, 0.14, 0.24, 0.9, 0.06),
    "held13/upland": (0.09, 0.09, 0.16, 1.4, 0.04),
    "held14/diamond": (0.06, 0.11, 0.26, 0.6, 0.07),
    "held14/railside": (0.11, 0.06, 0.19, 1.2, 0.05),
    "held15/sideroads": (0.04, 0.13, 0.21, 1.1, 0.08),
    "held15/turbine": (0.13, 0.08, 0.34, 0.4, 0.06),
    "held17/walls": (0.07, 0.12, 0.2, 1.0, 0.05),
    "held17/tee": (0.09, 0.15, 0.31, 0.5, 0.07),
    "held18/freeway": (0.08, 0.13, 0.27, 0.6, 0.06),
    "held18/downtown": (0.06, 0.1, 0.22, 1.1, 0.05),
    "held19/belt": (0.07, 0.11, 0.21, 1.2, 0.05),
    "held19/drops": (0.1, 0.12, 0.29, 0.5, 0.06),
    "held16/boulevard": (0.05, 0.17, 0.23, 1.3, 0.05),
    "held16/parclo": (0.1, 0.1, 0.29, 0.7, 0.09),
}
