import org.hipparchus.geometry.euclidean.threed.Rotation;
import org.hipparchus.geometry.euclidean.threed.Vector3D;
import org.orekit.attitudes.Attitude;
import org.orekit.attitudes.Inertia;
import org.orekit.attitudes.InertiaAxis;
import org.orekit.attitudes.TorqueFree;
import org.orekit.frames.Frame;
import org.orekit.frames.FramesFactory;
import org.orekit.time.AbsoluteDate;

/** Orekit's TorqueFree asked for many instants in one call. */
public final class TorqueFreeLoop {

    /** Four numbers of the quaternion, three of the rate. */
    private static final int WIDTH = 7;

    private final AbsoluteDate epoch = AbsoluteDate.ARBITRARY_EPOCH;
    private final Frame frame = FramesFactory.getGCRF();
    private final TorqueFree law;

    /**
     * @param moments principal moments, kg m2
     * @param axes the three principal axes in the body frame, one after the other
     * @param q attitude at the epoch, body to inertial, scalar first
     * @param omega rate at the epoch, body frame, rad/s
     */
    public TorqueFreeLoop(final double[] moments, final double[] axes, final double[] q, final double[] omega) {
        // Hipparchus turns a vector by conj(q) v q, which is inertial to body where q v conj(q) is body to inertial
        final Rotation rotation = new Rotation(q[0], q[1], q[2], q[3], true);
        final Vector3D spin = new Vector3D(omega[0], omega[1], omega[2]);
        final InertiaAxis[] inertia = new InertiaAxis[3];
        for (int k = 0; k < 3; k++) {
            inertia[k] = new InertiaAxis(moments[k], new Vector3D(axes[3 * k], axes[3 * k + 1], axes[3 * k + 2]));
        }
        law = new TorqueFree(new Attitude(epoch, frame, rotation, spin, Vector3D.ZERO),
                             new Inertia(inertia[0], inertia[1], inertia[2]));
    }

    /**
     * @param instants s since the epoch
     * @return quaternion (body to inertial, scalar first) and rate (body frame, rad/s), instant after instant
     */
    public double[] evaluate(final double[] instants) {
        final double[] out = new double[WIDTH * instants.length];
        int k = 0;
        for (final double t : instants) {
            final Attitude attitude = law.getAttitude(null, epoch.shiftedBy(t), frame);
            final Rotation rotation = attitude.getRotation();
            final Vector3D spin = attitude.getSpin();
            out[k++] = rotation.getQ0();
            out[k++] = rotation.getQ1();
            out[k++] = rotation.getQ2();
            out[k++] = rotation.getQ3();
            out[k++] = spin.getX();
            out[k++] = spin.getY();
            out[k++] = spin.getZ();
        }
        return out;
    }
}
