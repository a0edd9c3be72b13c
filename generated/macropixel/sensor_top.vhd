-- Component of the Verilog module sensor_top, for VHDL that instantiates it:
--   use work.sensor_top_pkg.all;
-- Compile the Verilog into the same library; the tool binds the component by its name.
-- Made by  goldtof emit macropixel.toml (goldtof 0.1.0)

library ieee;
use ieee.std_logic_1164.all;

package sensor_top_pkg is

    -- Bits of the ports
    constant SENSOR_TOP_I_CLK_BITS : positive := 1;
    constant SENSOR_TOP_I_RST_BITS : positive := 1;
    constant SENSOR_TOP_O_LASER_BITS : positive := 1;
    constant SENSOR_TOP_O_EPOCH_BITS : positive := 1;
    constant SENSOR_TOP_I_SAMPLES_BITS : positive := 16;
    constant SENSOR_TOP_M_AXIS_TDATA_BITS : positive := 16;
    constant SENSOR_TOP_M_AXIS_TVALID_BITS : positive := 1;
    constant SENSOR_TOP_M_AXIS_TREADY_BITS : positive := 1;
    constant SENSOR_TOP_M_AXIS_TLAST_BITS : positive := 1;
    constant SENSOR_TOP_O_OVERRUN_BITS : positive := 1;

    component sensor_top is
        port (
            i_clk         : in  std_logic;
            i_rst         : in  std_logic;
            o_laser       : out std_logic;
            o_epoch       : out std_logic;
            i_samples     : in  std_logic_vector(15 downto 0);
            m_axis_tdata  : out std_logic_vector(15 downto 0);
            m_axis_tvalid : out std_logic;
            m_axis_tready : in  std_logic;
            m_axis_tlast  : out std_logic;
            o_overrun     : out std_logic
        );
    end component;

end package;
