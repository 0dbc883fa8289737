"""Small rolling stock of railML, made by hand from the published documentation of the schema."""

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
