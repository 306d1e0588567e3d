"""What the benchmark tells about its own sequences; numbers of images are those in their names.

Source: the lists beside the reference code of [OTB2015].
"""

ATTRIBUTES = {
    "IV": "illumination variation",
    "SV": "scale variation",
    "OCC": "occlusion",
    "DEF": "deformation",
    "MB": "motion blur",
    "FM": "fast motion",
    "IPR": "in-plane rotation",
    "OPR": "out-of-plane rotation",
    "OV": "out of view",
    "BC": "background clutter",
    "LR": "low resolution",
}
"""The eleven challenges by which the benchmark groups its sequences."""

TB50_ATTRIBUTES = {
    name: tuple(tags.split(","))
    for name, tags in (
        line.split()
        for line in """
        Basketball IV,OCC,DEF,OPR,BC
        Biker SV,OCC,MB,FM,OPR,OV,LR
        Bird1 DEF,FM,OV
        BlurBody SV,DEF,MB,FM,IPR
        BlurCar2 SV,MB,FM
        BlurFace MB,FM,IPR
        BlurOwl SV,MB,FM,IPR
        Bolt OCC,DEF,IPR,OPR
        Box IV,SV,OCC,MB,IPR,OPR,OV,BC,LR
        Car1 IV,SV,MB,FM,BC,LR
        Car4 IV,SV
        CarDark IV,BC
        CarScale SV,OCC,FM,IPR,OPR
        ClifBar SV,OCC,MB,FM,IPR,OV,BC
        Couple SV,DEF,FM,OPR,BC
        Crowds IV,DEF,BC
        David IV,SV,OCC,DEF,MB,IPR,OPR
        Deer MB,FM,IPR,BC,LR
        Diving SV,DEF,IPR
        DragonBaby SV,OCC,MB,FM,IPR,OPR,OV
        Dudek SV,OCC,DEF,FM,IPR,OPR,OV,BC
        Football OCC,IPR,OPR,BC
        Freeman4 SV,OCC,IPR,OPR
        Girl SV,OCC,IPR,OPR
        Human3 SV,OCC,DEF,OPR,BC
        Human4-2 IV,SV,OCC,DEF
        Human6 SV,OCC,DEF,FM,OPR,OV
        Human9 IV,SV,DEF,MB,FM
        Ironman IV,SV,OCC,MB,FM,IPR,OPR,OV,BC,LR
        Jump SV,OCC,DEF,MB,FM,IPR,OPR
        Jumping MB,FM
        Liquor IV,SV,OCC,MB,FM,OPR,OV,BC
        Matrix IV,SV,OCC,FM,IPR,OPR,BC
        MotorRolling IV,SV,MB,FM,IPR,BC,LR
        Panda SV,OCC,DEF,IPR,OPR,OV,LR
        RedTeam SV,OCC,IPR,OPR,LR
        Shaking IV,SV,IPR,OPR,BC
        Singer2 IV,DEF,IPR,OPR,BC
        Skating1 IV,SV,OCC,DEF,OPR,BC
        Skating2-1 SV,OCC,DEF,FM,OPR
        Skating2-2 SV,OCC,DEF,FM,OPR
        Skiing IV,SV,DEF,IPR,OPR
        Soccer IV,SV,OCC,MB,FM,IPR,OPR,BC
        Surfer SV,FM,IPR,OPR,LR
        Sylvester IV,IPR,OPR
        Tiger2 IV,OCC,DEF,MB,FM,IPR,OPR,OV
        Trellis IV,SV,IPR,OPR,BC
        Walking SV,OCC,DEF
        Walking2 SV,OCC,LR
        Woman IV,SV,OCC,DEF,MB,FM,OPR
        """.strip().splitlines()
    )
}
"""The fifty sequences of TB-50 and their challenges."""

FIRST_IMAGE = {"David": 300, "BlurCar1": 247, "BlurCar3": 3, "BlurCar4": 18}
"""The image of the first box, where it is not the first image."""

LAST_IMAGE = {
    "David": 770,
    "Diving": 215,
    "Football1": 74,
    "Freeman3": 460,
    "Freeman4": 283,
}
"""The image of the last box, where it is not the last image."""

NO_START = {
    "basketball": "8-27 619-628 639-659",
    "carscale": "155-177 202-225",
    "dudek": "204-218 357-372 971-988 1090-1116",
    "football": "58-65 76-84 279-305 319-362",
    "freeman4": "7-8 16-17 25-26 34-38 42-51 61-74 81-82 102-103 116-117 126-130 142-148 156-168 "
    "181-181 184-188 205-207 239-256 268-297",
    "girl": "421-443 451-469",
    "ironman": "102-114 144-145 156-164",
    "liquor": "383-410 502-510 604-608 723-735 768-779 1181-1187 1236-1238 1286-1289 1318-1321 "
    "1351-1358 1502-1507 1515-1521 1606-1609",
    "matrix": "36-40",
    "redteam": "1521-1527",
    "skating1": "154-189",
    "soccer": "93-231 350-392",
    "tiger2": "72-76 80-118 124-153 165-190 196-203 207-225 233-276 285-321 325-340 346-365",
    "walking": "81-94",
    "walking2": "188-233 370-378",
    "woman": "106-172 189-247 262-334 356-413 457-525 544-597",
}
"""First and last images of the stretches in which no run of TRE may start (`initOmit`), by the
name in lower case; the target is hidden or out of view there. Sequences that are not listed have
none in the reference code of 2013; those added later bring theirs in `init_omit.txt`."""
