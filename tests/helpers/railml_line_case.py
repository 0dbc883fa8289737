"""Small lines of railML, made by hand from the published documentation of the schema."""

import pytest

LINE_2 = """<?xml version="1.0" encoding="UTF-8"?>
<railml xmlns="http://www.railml.org/schemas/2016" xmlns:x="urn:extension" version="2.3">
 <infrastructure id="inf">
  <tracks>
   <track id="t1" name="Main" type="mainTrack" mainDir="up">
    <trackTopology>
     <trackBegin id="b" pos="100"><openEnd id="oe1"/></trackBegin>
     <trackEnd id="e" pos="10100"><openEnd id="oe2"/></trackEnd>
     <crossSections>
      <crossSection id="cs1" pos="4100" ocpRef="halt"/>
      <crossSection id="cs2" pos="6100" ocpRef="block"/>
     </crossSections>
    </trackTopology>
    <trackElements>
     <speedChanges>
      <speedChange id="s1" pos="100" dir="up" vMax="90" trainRelation="headOfTrain"/>
      <speedChange id="s2" pos="3100" dir="up" vMax="120" trainRelation="headOfTrain"/>
      <speedChange id="s3" pos="9100" dir="up" vMax="100" trainRelation="headOfTrain"/>
      <speedChange id="s4" pos="10100" dir="down" vMax="80"/>
      <speedChange id="s5" pos="2100" dir="down" vMax="110"/>
     </speedChanges>
     <gradientChanges>
      <gradientChange id="g1" pos="100" dir="up" slope="5.0" transitionLength="20"/>
      <gradientChange id="g2" pos="2100" dir="up" slope="-4.0"/>
     </gradientChanges>
     <radiusChanges>
      <radiusChange id="r1" pos="100" dir="up" radius="0"/>
      <radiusChange id="r2" pos="1100" dir="up" radius="-400"/>
      <radiusChange id="r3" pos="1600" dir="up" radius="0"/>
     </radiusChanges>
     <tunnels>
      <tunnel id="tu1" pos="7100" length="1050" crossSection="40"/>
      <tunnel id="tu2" pos="8600" length="100"/>
     </tunnels>
     <x:extra/>
    </trackElements>
    <ocsElements><signals><signal id="sig" pos="500"/></signals></ocsElements>
   </track>
  </tracks>
  <operationControlPoints>
   <ocp id="halt"><propOperational operationalType="stoppingPoint"/></ocp>
   <ocp id="block"><propOperational operationalType="blockPost"/></ocp>
  </operationControlPoints>
 </infrastructure>
</railml>
"""

LINE_3 = """<?xml version="1.0" encoding="UTF-8"?>
<railML xmlns="https://www.railml.org/schemas/3.1" version="3.1">
 <common id="co"/>
 <infrastructure id="is">
  <topology id="top">
   <netElements>
    <netElement id="ne1" length="4000">
     <associatedPositioningSystem id="aps1">
      <intrinsicCoordinate id="i1" intrinsicCoord="0">
       <linearCoordinate positioningSystemRef="lps" measure="1000"/>
      </intrinsicCoordinate>
      <intrinsicCoordinate id="i2" intrinsicCoord="1">
       <linearCoordinate positioningSystemRef="lps" measure="5000"/>
      </intrinsicCoordinate>
     </associatedPositioningSystem>
    </netElement>
    <netElement id="ne2" length="6000"/>
   </netElements>
  </topology>
  <geometry id="geo">
   <gradientCurves>
    <gradientCurve id="gc1" gradient="5.0" curveType="straight">
     <linearLocation id="l1" applicationDirection="both">
      <associatedNetElement netElementRef="ne1" keepsOrientation="true" posBegin="0" posEnd="2000"/>
     </linearLocation>
    </gradientCurve>
    <gradientCurve id="gc2" gradient="-4.0" curveType="straight">
     <linearLocation id="l2" applicationDirection="both">
      <associatedNetElement netElementRef="ne1" keepsOrientation="true" sequence="1"
                            intrinsicCoordBegin="0.5" intrinsicCoordEnd="1"/>
      <associatedNetElement netElementRef="ne2" keepsOrientation="false" sequence="2" posBegin="6000" posEnd="0"/>
     </linearLocation>
    </gradientCurve>
   </gradientCurves>
   <horizontalCurves>
    <horizontalCurve id="hc1" curveType="clothoid">
     <linearLocation id="l3"><associatedNetElement netElementRef="ne1" posBegin="900" posEnd="1000"/></linearLocation>
    </horizontalCurve>
    <horizontalCurve id="hc2" curveType="arc" radius="400">
     <linearLocation id="l4"><associatedNetElement netElementRef="ne1" posBegin="1000" posEnd="1500"/></linearLocation>
    </horizontalCurve>
   </horizontalCurves>
  </geometry>
  <functionalInfrastructure id="fi">
   <speeds>
    <speedSection id="ss1" maxSpeed="90">
     <linearLocation id="l5" applicationDirection="both">
      <associatedNetElement netElementRef="ne1" keepsOrientation="true">
       <linearCoordinateBegin positioningSystemRef="lps" measure="1000"/>
       <linearCoordinateEnd positioningSystemRef="lps" measure="4000"/>
      </associatedNetElement>
     </linearLocation>
    </speedSection>
    <speedSection id="ss2" maxSpeed="120">
     <linearLocation id="l6" applicationDirection="both">
      <associatedNetElement netElementRef="ne1" posBegin="0" posEnd="4000"/>
      <associatedNetElement netElementRef="ne2"/>
     </linearLocation>
    </speedSection>
   </speeds>
   <operationalPoints>
    <operationalPoint id="op1"><opOperations><opOperation operationalType="station"/></opOperations>
     <spotLocation id="sl" netElementRef="ne2" pos="6000"/>
    </operationalPoint>
    <operationalPoint id="op2">
     <spotLocation id="sl2" netElementRef="ne2" intrinsicCoord="0.5"/>
    </operationalPoint>
    <operationalPoint id="op3"><opOperations><opOperation operationalType="junction"/></opOperations>
     <spotLocation id="sl3" netElementRef="ne2" intrinsicCoord="0.25"/>
    </operationalPoint>
   </operationalPoints>
   <overCrossings>
    <overCrossing id="oc" constructionType="tunnel">
     <linearLocation id="l7"><associatedNetElement netElementRef="ne1" posBegin="100" posEnd="300"/></linearLocation>
    </overCrossing>
   </overCrossings>
   <tracks>
    <track id="t1" type="mainTrack">
     <name name="Main" language="en"/>
     <linearLocation id="l8">
      <associatedNetElement netElementRef="ne1" keepsOrientation="true" sequence="1"/>
      <associatedNetElement netElementRef="ne2" keepsOrientation="false" sequence="2"/>
     </linearLocation>
    </track>
   </tracks>
  </functionalInfrastructure>
 </infrastructure>
</railML>
"""


def limits_kmh(track):
    return [(row.position_m, pytest.approx(3.6 * row.speed_mps)) for row in track.speed_limits]


def _mileage(end: int, measure: int) -> str:
    linear = f'<linearCoordinate positioningSystemRef="lps" measure="{measure}"/>'
    return f'<intrinsicCoordinate intrinsicCoord="{end}">{linear}</intrinsicCoordinate>'


#: As exports of interlocking tools write it: a track knows its length, net elements do not, and nothing says how fast.
BARE_3 = f"""<?xml version="1.0" encoding="UTF-8"?>
<railML xmlns="https://www.railml.org/schemas/3.1" version="3.1">
 <common><positioning><linearPositioningSystems>
  <linearPositioningSystem id="lps" units="m"/>
  <linearPositioningSystem id="screen" units="Km"/>
 </linearPositioningSystems></positioning></common>
 <infrastructure id="is">
  <topology><netElements>
   <netElement id="ne1"/>
   <netElement id="ne2"/>
   <netElement id="ne3"/>
   <netElement id="ne4"><associatedPositioningSystem>
    {_mileage(0, 900)}
    {_mileage(1, 200)}
   </associatedPositioningSystem></netElement>
   <netElement id="ne5"/>
   <netElement id="ne6"/>
   <netElement id="station">
    <elementCollectionUnordered><elementPart ref="ne1"/><elementPart ref="ne2"/></elementCollectionUnordered>
    <associatedPositioningSystem><intrinsicCoordinate intrinsicCoord="0">
     <linearCoordinate positioningSystemRef="lps" measure="0"/>
     <linearCoordinate positioningSystemRef="lps" measure="700"/>
    </intrinsicCoordinate></associatedPositioningSystem>
   </netElement>
   <netElement id="open"><associatedPositioningSystem>
    {_mileage(0, 700)}
    {_mileage(1, 4300)}
   </associatedPositioningSystem></netElement>
  </netElements></topology>
  <functionalInfrastructure>
   <lines><line id="line">
    <linearLocation>
     <associatedNetElement netElementRef="station"/><associatedNetElement netElementRef="open"/>
    </linearLocation>
    <linePerformance maxSpeed="80"/>
   </line></lines>
   <operationalPoints><operationalPoint id="op"><spotLocation netElementRef="station">
    <linearCoordinate positioningSystemRef="lps" measure="300"/></spotLocation></operationalPoint></operationalPoints>
   <tracks>
    <track id="alone"><linearLocation>
      <associatedNetElement keepsOrientation="false" netElementRef="ne1"/>
     </linearLocation><length value="510" type="physical"/></track>
    <track id="rest"><linearLocation>
      <associatedNetElement netElementRef="ne1" sequence="1"/><associatedNetElement netElementRef="ne2" sequence="2"/>
     </linearLocation><length value="800.5"/></track>
    <track id="reverse"><linearLocation><associatedNetElement netElementRef="ne2"/></linearLocation></track>
    <track id="mileage"><linearLocation><associatedNetElement netElementRef="ne4"/></linearLocation></track>
    <track id="together"><linearLocation>
      <associatedNetElement netElementRef="ne5" sequence="2"/><associatedNetElement netElementRef="ne1" sequence="1"/>
      <associatedNetElement netElementRef="ne6" sequence="3"/>
     </linearLocation><length value="2000"/></track>
    <track id="unknown"><linearLocation><associatedNetElement netElementRef="ne6"/></linearLocation></track>
    <track id="lost"><linearLocation><associatedNetElement netElementRef="null"/></linearLocation></track>
   </tracks>
  </functionalInfrastructure>
 </infrastructure>
</railML>
"""

#: A topology and nothing that runs on it.
BARE_NET = """<railML xmlns="https://www.railml.org/schemas/3.1" version="3.1"><infrastructure><topology><netElements>
<netElement id="ne" length="500"/></netElements></topology></infrastructure></railML>"""

#: As editors of track plans write it: tracks with ends, and no limit on them; no version but the namespace.
BARE_2 = """<?xml version="1.0"?>
<railml xmlns="http://www.railml.org/schemas/2013"><infrastructure><tracks>
 <track id="a"><trackTopology><trackBegin pos="0"/><trackEnd pos="350"/></trackTopology></track>
 <track id="b"><trackTopology><trackBegin pos="0"/><trackEnd pos="250"/></trackTopology><trackElements>
  <speedChanges><speedChange pos="50" dir="up" vMax="60"/><speedChange pos="150" dir="up" vMax="end"/></speedChanges>
  <radiusChanges><radiusChange pos="0" radius="0"/><radiusChange pos="0" radius="0"/>
    <radiusChange pos="70" radius="-850"/>
  </radiusChanges></trackElements></track>
</tracks></infrastructure></railml>
"""
