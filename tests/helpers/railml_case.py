"""Small railML files, made by hand from the published documentation of the schema, and how to change them."""

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

STOCK_2 = """<?xml version="1.0" encoding="UTF-8"?>
<railml xmlns="http://www.railml.org/schemas/2016" version="2.3">
 <rollingstock id="rs">
  <vehicles>
   <vehicle id="loco" name="Loco" length="20" speed="160" bruttoWeight="80" numberDrivenAxles="4">
    <engine>
     <propulsion id="ac" voltage="15000" frequency="16.7" power="4000000" rotationMassFactor="1.2"
                 totalTractEfficiency="0.85">
      <tractiveEffort>
       <valueTable xValueName="speed" xValueUnit="km/h" yValueName="effort" yValueUnit="kN">
        <valueLine xValue="0"><values yValue="300"/></valueLine>
        <valueLine xValue="72"><values yValue="200"/></valueLine>
        <valueLine xValue="144"><values yValue="100"/></valueLine>
       </valueTable>
      </tractiveEffort>
     </propulsion>
    </engine>
   </vehicle>
   <vehicle id="coach" name="Coach" length="26" speed="140" bruttoWeight="50" tareWeight="40"/>
  </vehicles>
  <formations>
   <formation id="ic" name="IC">
    <trainOrder>
     <vehicleRef orderNumber="1" vehicleRef="loco" vehicleCount="2"/>
     <vehicleRef orderNumber="2" vehicleRef="coach" vehicleCount="6"/>
    </trainOrder>
    <trainEngine maxAcceleration="0.6"/>
    <trainBrakes brakeType="compressedAir" meanDeceleration="0.7"/>
    <trainResistance>
     <daviesFormula constantFactorA="1.5" speedDependentFactorB="0.005" squareSpeedDependentFactorC="0.0002"
                    massDependent="true"/>
    </trainResistance>
   </formation>
  </formations>
 </rollingstock>
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

STOCK_3 = """<?xml version="1.0" encoding="UTF-8"?>
<railML xmlns="https://www.railml.org/schemas/3.2" version="3.2">
 <rollingstock id="rs">
  <vehicles>
   <vehicle id="emu" speed="160" bruttoWeight="130" tareWeight="110" length="75">
    <name name="EMU" language="en"/>
    <engine>
     <powerMode mode="electric" isPrimaryMode="true">
      <tractionData>
       <details>
        <tractiveEffort>
         <valueTable xValueUnit="km/h" yValueUnit="N">
          <valueLine xValue="0"><values yValue="150000"/></valueLine>
          <valueLine xValue="60"><values yValue="150000"/></valueLine>
          <valueLine xValue="160"><values yValue="56250"/></valueLine>
         </valueTable>
        </tractiveEffort>
       </details>
      </tractionData>
     </powerMode>
    </engine>
    <drivingResistance>
     <details>
      <valueTable xValueUnit="km/h" yValueUnit="kN">
       <valueLine xValue="0"><values yValue="2"/></valueLine>
       <valueLine xValue="50"><values yValue="3.25"/></valueLine>
       <valueLine xValue="100"><values yValue="6"/></valueLine>
       <valueLine xValue="150"><values yValue="10.25"/></valueLine>
      </valueTable>
     </details>
    </drivingResistance>
   </vehicle>
  </vehicles>
 </rollingstock>
</railML>
"""

#: As the schema of 3.2 has it: a table for all power modes beside them, units that it does not list, polynomials.
STOCK_32 = """<?xml version="1.0" encoding="UTF-8"?>
<railML xmlns="https://www.railml.org/schemas/3.2" version="3.2">
 <rollingstock id="rs">
  <vehicles>
   <vehicle id="loco" speed="160" bruttoWeight="80" length="20">
    <designator register="type" entry="Loco"/>
    <engine tractivePower="4000000">
     <powerMode mode="electric"/>
     <powerMode mode="battery"/>
     <tractiveEffort>
      <segmentTable segmentStartValueName="v" segmentStartValueUnit="km/h"
                    functionValueName="F" functionValueUnit="other:kN">
       <polynomialHeader exponentValue="0"/><polynomialHeader exponentValue="-1"/>
       <segmentStartLine segmentStartValue="0">
        <constantValue coefficientValue="300"/><constantValue coefficientValue="0"/>
       </segmentStartLine>
       <segmentStartLine segmentStartValue="48">
        <constantValue coefficientValue="0"/><constantValue coefficientValue="14400"/>
       </segmentStartLine>
      </segmentTable>
     </tractiveEffort>
    </engine>
    <brakes><brakeEffort><valueTable xValueName="v" xValueUnit="km/h" yValueName="F" yValueUnit="other:kN">
     <valueLine xValue="0"><value yValue="150"/></valueLine>
    </valueTable></brakeEffort></brakes>
   </vehicle>
   <vehicle id="coach" speed="200" bruttoWeight="50" length="26"><designator register="type" entry="Coach"/></vehicle>
  </vehicles>
  <formations>
   <formation id="ic" speed="160" totalWeight="200" length="72">
    <designator register="type" entry="IC"/>
    <trainOrder orderNumber="1" vehicleRef="loco"/>
    <trainOrder orderNumber="2" vehicleRef="coach"/>
    <trainOrder orderNumber="3" vehicleRef="coach"/>
    <trainEngine maxAcceleration="0.6"/>
    <trainBrakes meanDeceleration="0.7"/>
    <trainResistance>
     <segmentTable segmentStartValueName="v" segmentStartValueUnit="km/h"
                   functionValueName="R" functionValueUnit="N">
      <polynomialHeader exponentValue="0"/><polynomialHeader exponentValue="1"/><polynomialHeader exponentValue="2"/>
      <segmentStartLine segmentStartValue="0">
       <constantValue coefficientValue="2000"/><constantValue coefficientValue="10"/>
       <constantValue coefficientValue="0.3"/>
      </segmentStartLine>
     </segmentTable>
    </trainResistance>
   </formation>
  </formations>
 </rollingstock>
</railML>
"""

#: As the schema of 3.3 has it, with a prefix before each name.
STOCK_33 = """<?xml version="1.0" encoding="UTF-8"?>
<rail3:railML xmlns:rail3="https://www.railml.org/schemas/3.3" version="3.3">
 <rail3:rollingstock>
  <rail3:vehicles>
   <rail3:vehicle id="loco" speed="140" bruttoWeight="130" tareWeight="130" length="20" adhesionWeight="130"
                  rotatingMassFactor="1.15">
    <rail3:engine><rail3:powerMode mode="diesel" isPrimaryMode="true"><rail3:tractionData>
     <rail3:info maxTractiveEffort="250000" tractivePower="2400000"/>
     <rail3:details><rail3:tractiveEffort>
      <rail3:valueTable xValueName="speed" xValueUnit="km/h" yValueName="effort" yValueUnit="N">
       <rail3:valueLine xValue="0"><rail3:value yValue="270000"/></rail3:valueLine>
       <rail3:valueLine xValue="40"><rail3:value yValue="200000"/></rail3:valueLine>
       <rail3:valueLine xValue="120"><rail3:value yValue="66000"/></rail3:valueLine>
      </rail3:valueTable></rail3:tractiveEffort></rail3:details>
    </rail3:tractionData></rail3:powerMode></rail3:engine>
   </rail3:vehicle>
   <rail3:vehicle id="coach" speed="200" bruttoWeight="50" tareWeight="40" length="26"/>
  </rail3:vehicles>
  <rail3:formations>
   <rail3:formation id="ic" speed="140" bruttoWeight="180" length="46" numberOfWagons="1">
    <rail3:designator register="operator" entry="IC"/>
    <rail3:trainOrder orderNumber="1" vehicleRef="loco"/><rail3:trainOrder orderNumber="2" vehicleRef="coach"/>
    <rail3:trainEngine maxAcceleration="0.4"><rail3:tractionMode mode="diesel" isPrimaryMode="true">
     <rail3:tractionData><rail3:info maxTractiveEffort="270000" tractivePower="2420000"/></rail3:tractionData>
    </rail3:tractionMode></rail3:trainEngine>
    <rail3:trainBrakes meanDeceleration="0.8"/>
    <rail3:trainResistance tunnelFactor="1.8">
     <rail3:daviesFormulaFactors constantFactorA="3800" speedDependentFactorB="45"
                                 squareSpeedDependentFactorC="2.5" massDependent="false"/>
    </rail3:trainResistance>
   </rail3:formation>
  </rail3:formations>
 </rail3:rollingstock>
</rail3:railML>
"""


def limits_kmh(track):
    return [(row.position_m, pytest.approx(3.6 * row.speed_mps)) for row in track.speed_limits]


SAMPLES = {
    "line_2": LINE_2,
    "stock_2": STOCK_2,
    "line_3": LINE_3,
    "stock_3": STOCK_3,
    "stock_32": STOCK_32,
    "stock_33": STOCK_33,
}


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
