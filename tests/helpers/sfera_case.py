"""Small messages of SFERA: a journey over two segments, of which the second is run in reverse, and its train."""

ZONE = "<SP_Zone><IM_ID>0099</IM_ID></SP_Zone>"
START = '<?xml version="1.0"?>\n'

JOURNEY = f"""
<JourneyProfile JP_Status="Valid" JP_Version="7">
  <TrainIdentification>
    <OTN_ID>
      <teltsi_Company>9901</teltsi_Company>
      <teltsi_OperationalTrainNumber>4711</teltsi_OperationalTrainNumber>
      <teltsi_StartDate>2026-05-04</teltsi_StartDate>
    </OTN_ID>
  </TrainIdentification>
  <SegmentProfileReference SP_ID="s1" SP_VersionMajor="1" SP_VersionMinor="2" SP_Direction="Nominal">
    {ZONE}
    <TimingPointConstraints TP_StopSkipPass="Stopping_Point">
      <TimingPointReference><TP_ID_Reference TP_ID="a"/></TimingPointReference>
      <StoppingPointDepartureDetails departureTime="2026-05-04T23:58:00Z"/>
    </TimingPointConstraints>
    <TimingPointConstraints TP_latestArrivalTime="2026-05-05T00:02:30Z" TP_StopSkipPass="Passing_Point">
      <TimingPointReference><TP_ID_Reference TP_ID="b"/></TimingPointReference>
    </TimingPointConstraints>
    <TemporaryConstraints startLocation="3500" startEndQualifier="Starts" temporaryConstraintType="ASR">
      <AdditionalSpeedRestriction ASR_Front="false" ASR_Speed="50"/>
    </TemporaryConstraints>
    <TrainCharacteristicsRef TC_ID="ic" TC_VersionMajor="3" location="0" trainWeight="220">
      <TC_RU_ID>9901</TC_RU_ID>
    </TrainCharacteristicsRef>
  </SegmentProfileReference>
  <SegmentProfileReference SP_ID="s2" SP_VersionMajor="1" SP_VersionMinor="0" SP_Direction="Reverse">
    {ZONE}
    <TimingPointConstraints TP_latestArrivalTime="2026-05-05T00:05:00Z" arrivalWindow="PT1M30S"
      TP_StopSkipPass="Stopping_Point">
      <TimingPointReference><TP_ID_Reference TP_ID="c"/></TimingPointReference>
      <StoppingPointDepartureDetails departureTime="2026-05-05T00:06:00Z"/>
    </TimingPointConstraints>
    <TimingPointConstraints TP_latestArrivalTime="2026-05-05T00:10:00Z" TP_StopSkipPass="Stopping_Point">
      <TimingPointReference><TP_ID_Reference TP_ID="d"/></TimingPointReference>
    </TimingPointConstraints>
    <TemporaryConstraints endLocation="5500" startEndQualifier="Ends" temporaryConstraintType="ASR">
      <AdditionalSpeedRestriction ASR_Front="false" ASR_Speed="50"/>
    </TemporaryConstraints>
  </SegmentProfileReference>
</JourneyProfile>
"""

SEGMENT_1 = f"""
<SegmentProfile SP_ID="s1" SP_VersionMajor="1" SP_VersionMinor="2" SP_Length="4000">
  {ZONE}
  <SP_Points>
    <TimingPoint TP_ID="a" location="200"><TP_Name name="Aston"/></TimingPoint>
    <TimingPoint TP_ID="b" location="2500"/>
    <Signal>
      <Signal_ID signal_ID_Physical="x1" location="1000"/>
      <SignalInformation><PowerConstraint powerConstraintInstruction="Pantograph_Down"/></SignalInformation>
    </Signal>
    <Signal>
      <Signal_ID signal_ID_Physical="x2" location="1200"/>
      <SignalInformation><PowerConstraint powerConstraintInstruction="Pantograph_Up"/></SignalInformation>
    </Signal>
  </SP_Points>
  <SP_Areas>
    <Tunnel startLocation="3000" startEndQualifier="Starts" tunnelFactor="50"/>
  </SP_Areas>
  <SP_Characteristics>
    <StaticSpeedProfile>
      <StaticSpeedProfileStart SSP_Speed="90" SSP_Front="false"/>
      <StaticSpeedProfileChange SSP_Speed="120" SSP_Front="true" location="1500"/>
    </StaticSpeedProfile>
    <Gradient>
      <GradientStart gradientValue="0" gradientDirection="Downhill"/>
      <GradientChange gradientValue="12.5" gradientDirection="Uphill" location="1000"/>
    </Gradient>
    <Curves>
      <CurveStart curveRadius="0"/>
      <CurveChange curveRadius="600" curveDirection="Left" location="2000"/>
      <CurveChange curveRadius="0" location="2400"/>
    </Curves>
  </SP_Characteristics>
</SegmentProfile>
"""

SEGMENT_2 = f"""
<SegmentProfile SP_ID="s2" SP_VersionMajor="1" SP_VersionMinor="0" SP_Length="6000">
  {ZONE}
  <SP_Points>
    <TimingPoint TP_ID="c" location="3500">
      <TAF_TAP_LocationReference>
        <teltsi_CountryCodeISO>XX</teltsi_CountryCodeISO>
        <teltsi_LocationPrimaryCode>12</teltsi_LocationPrimaryCode>
      </TAF_TAP_LocationReference>
    </TimingPoint>
    <TimingPoint TP_ID="d" location="300"/>
  </SP_Points>
  <SP_Areas>
    <Tunnel startLocation="5600" startEndQualifier="Starts" tunnelFactor="50"/>
    <TAF_TAP_Location startLocation="3500" endLocation="3500" startEndQualifier="StartsEnds">
      <TAF_TAP_LocationIdent>
        <teltsi_CountryCodeISO>XX</teltsi_CountryCodeISO>
        <teltsi_LocationPrimaryCode>12</teltsi_LocationPrimaryCode>
        <teltsi_PrimaryLocationName>Ceeville</teltsi_PrimaryLocationName>
      </TAF_TAP_LocationIdent>
    </TAF_TAP_Location>
  </SP_Areas>
  <SP_Characteristics>
    <StaticSpeedProfile>
      <StaticSpeedProfileStart SSP_Speed="80" SSP_Front="true"/>
      <StaticSpeedProfileChange SSP_Speed="100" SSP_Front="true" location="1000"/>
    </StaticSpeedProfile>
    <Gradient>
      <GradientStart gradientValue="4" gradientDirection="Uphill"/>
      <GradientChange gradientValue="2" gradientDirection="Downhill" location="2000"/>
    </Gradient>
    <CurrentLimitation>
      <CurrentLimitationStart maxCurValue="1023"/>
      <CurrentLimitationChange maxCurValue="0" location="4000"/>
      <CurrentLimitationChange maxCurValue="1023" location="4100"/>
    </CurrentLimitation>
  </SP_Characteristics>
</SegmentProfile>
"""

TRAIN = """
<TrainCharacteristics TC_ID="ic" TC_VersionMajor="3">
  <TC_RU_ID>9901</TC_RU_ID>
  <TC_Features trainLength="100" trainMaxSpeed="140" trainWeight="200" comfortableBraking="0.7"
    rolloutCoefficientA="1500" rolloutCoefficientB="30" rolloutCoefficientC="6" rotatingMassFactor="1.06">
    <TractionForceCurve>
      <TractionForceCurveDataPoint speed="0" tractionForce="200000"/>
      <TractionForceCurveDataPoint speed="72" tractionForce="100000"/>
      <TractionForceCurveDataPoint speed="144" tractionForce="50000"/>
      <TFC_TractionType><Diesel/></TFC_TractionType>
    </TractionForceCurve>
    <BrakingForceCurve>
      <BrakingForceCurveDataPoint speed="0" brakingForce="180000"/>
      <BrakingForceCurveDataPoint speed="144" brakingForce="160000"/>
    </BrakingForceCurve>
  </TC_Features>
</TrainCharacteristics>
"""

PARTS = (JOURNEY, SEGMENT_1, SEGMENT_2, TRAIN)


def message(*parts):
    """All of some messages in one, as a reply to a train holds them."""
    return f"{START}<G2B_ReplyPayload>{''.join(parts or PARTS)}</G2B_ReplyPayload>\n"


def swiss(group, name, rows):
    """A group of Swiss parameters with speeds as XML in a value, by rows of attributes."""
    inner = "".join(f"<v {row}/>" for row in rows)
    value = f"<speeds>{inner}</speeds>".replace("<", "&lt;").replace('"', "&quot;")
    return (
        f"<teltsi_Company>0085</teltsi_Company><NSP_GroupName>{group}</NSP_GroupName>"
        f'<NetworkSpecificParameter name="{name}" value="{value}"/>'
    )


def valid_by(schema, text):
    """Whether a message is valid by the published schema, with what is wrong."""
    from lxml import etree

    xsd = etree.XMLSchema(etree.parse(schema))
    return xsd.validate(etree.fromstring(text.encode() if isinstance(text, str) else text)), str(xsd.error_log)


def limits_of(track):
    return [(limit.position_m, round(3.6 * limit.speed_mps, 9)) for limit in track.speed_limits]


def edited(*changes, parts=PARTS):
    """The message with texts replaced, each of which is there once."""
    text = message(*parts)
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text
